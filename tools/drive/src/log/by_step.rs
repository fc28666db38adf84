//! Items of topics, joined by their steps or times.

/// The item of `step`, or of a time, from a sequence in their order; skips earlier items.
pub(crate) fn take_step<'a, T, K: Ord>(
    items: &mut std::iter::Peekable<std::slice::Iter<'a, T>>,
    step: K,
    step_of: impl Fn(&T) -> K,
) -> Option<&'a T> {
    while items.next_if(|item| step_of(item) < step).is_some() {}
    items.next_if(|item| step_of(item) == step)
}

/// Puts second messages to the first ones of their steps. A second message is sent before the first one: those of later
/// steps stay in `waiting`. `steps` gives the step of a first and of a second message.
pub(crate) fn join<F, M>(
    firsts: &mut [F],
    waiting: &mut Vec<M>,
    steps: (impl Fn(&F) -> u64, impl Fn(&M) -> u64),
    put: impl Fn(&mut F, &M),
) {
    waiting.retain(|second| {
        let step = steps.1(second);
        let waits = firsts.last().is_none_or(|last| steps.0(last) < step);
        let first = firsts.iter_mut().rev().find(|first| steps.0(first) <= step);
        if let Some(first) = first.filter(|first| steps.0(first) == step) {
            put(first, second);
        }
        waits
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_joined_by_step() {
        let items = [(0, 'a'), (5, 'b'), (10, 'c')];
        let mut iter = items.iter().peekable();
        let mut at = |step| take_step(&mut iter, step, |item| item.0).map(|item| item.1);
        assert_eq!([at(0), at(1), at(6), at(10), at(11)], [Some('a'), None, None, Some('c'), None]);
    }
}
