//! The gate for a process's messages: a standby keeps them back, a replaced process may not send.

use crate::survival::fence::{self, Fences};
use messages::Service;
use std::cell::Cell;
use std::sync::atomic::AtomicU32;

/// Decision on a message that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    /// It is sent.
    Open,
    /// It is kept, since the process is a standby.
    Held,
    /// It is dropped, since the process was replaced.
    Shut,
}

/// The gate of one process, shared by its ports.
#[derive(Debug)]
pub(crate) struct Gate {
    fences: Option<Fences>,
    service: Service,
    incarnation: u32,
    is_standby: Cell<bool>,
}

impl Gate {
    pub(crate) fn of(fences: Option<Fences>, service: Service, incarnation: u32) -> Self {
        Self { fences, service, incarnation, is_standby: Cell::new(false) }
    }

    /// Always open: of a sender without a standby.
    pub(crate) fn open(service: Service) -> Self {
        Self::of(None, service, 0)
    }

    /// Makes the process a standby, or ends that.
    pub(crate) fn set_standby(&self, is_standby: bool) {
        self.is_standby.set(is_standby);
    }

    /// True while the process is a standby.
    pub(crate) fn is_standby(&self) -> bool {
        self.is_standby.get()
    }

    /// The service's epoch; `None` where it has no standby.
    fn word(&self) -> Option<&AtomicU32> {
        self.fences.as_ref().and_then(|fences| fences.of_service(self.service))
    }

    /// Makes this process the active one, if it replaces one that is gone; false if
    /// another process is it.
    pub(crate) fn claim(&self) -> bool {
        self.word().is_none_or(|word| fence::claim(word, self.incarnation))
    }

    /// Decision on a message that is sent now.
    pub(crate) fn passage(&self) -> Passage {
        if self.is_standby() {
            return Passage::Held;
        }
        match self.word() {
            Some(word) if !fence::may_send(word, self.incarnation) => Passage::Shut,
            _ => Passage::Open,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survival::fence::tests::Run;

    #[test]
    fn without_a_standby_of_its_service_a_gate_is_open_until_it_stands_by() {
        let run = Run::new("open", &[Service::PerceptionSim]);
        let of_another = Gate::of(Some(run.fences()), Service::Plant, 3);
        for gate in [Gate::open(Service::Plant), of_another] {
            assert!(gate.claim() && !gate.is_standby());
            assert_eq!(gate.passage(), Passage::Open);
            gate.set_standby(true);
            assert!(gate.is_standby());
            assert_eq!(gate.passage(), Passage::Held);
            gate.set_standby(false);
            assert_eq!(gate.passage(), Passage::Open);
        }
    }

    #[test]
    fn a_standby_holds_its_messages_and_a_replaced_process_sends_nothing() {
        let service = Service::Controller;
        let run = Run::new("replaced", &[service]);
        let [active, standby] = [0, 1].map(|own| Gate::of(Some(run.fences()), service, own));
        assert!(active.claim());
        standby.set_standby(true);
        assert_eq!((active.passage(), standby.passage()), (Passage::Open, Passage::Held));
        let fences = run.fences();
        let word = fences.of_service(service).expect("it has a standby");
        assert!(fence::take_over(word, 0, 1));
        // The standby is silent until its loop ends the time as a standby.
        assert_eq!((active.passage(), standby.passage()), (Passage::Shut, Passage::Held));
        standby.set_standby(false);
        assert_eq!((active.passage(), standby.passage()), (Passage::Shut, Passage::Open));
        assert!(!active.claim() && standby.claim());
    }

    #[test]
    fn a_process_that_is_started_cold_claims_a_later_epoch_alone() {
        let service = Service::Aebs;
        let run = Run::new("cold", &[service]);
        let gate = |own| Gate::of(Some(run.fences()), service, own);
        assert_eq!(gate(4).passage(), Passage::Shut, "not claimed");
        assert!(gate(4).claim() && gate(4).claim() && !gate(3).claim());
        assert_eq!((gate(3).passage(), gate(4).passage()), (Passage::Shut, Passage::Open));
    }
}
