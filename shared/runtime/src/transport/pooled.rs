//! iceoryx2's variant for processes with one difference: what its ports count references with comes from a
//! pool.
//!
//! iceoryx2 0.10 makes a reference count on the heap for every loan (`ChunkMutSharedState::new`), whatever
//! the variant. The type that counts is a part of the variant, though. Here it takes its memory from blocks
//! that it has used before: no loop allocates. Nothing in shared memory differs. So programs that use
//! iceoryx2's own variant, such as Python's, meet on the same topics.

#![allow(unsafe_code, reason = "a reference count in memory that is used again")]

use iceoryx2::service::internal::ServiceInternal;
use iceoryx2::service::{Service, ipc};
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use iceoryx2_cal::arc_sync_policy::{ArcSyncPolicy, ArcSyncPolicyCreationError, LockGuard};
use std::alloc::{Layout, alloc, dealloc};
use std::cell::{Cell, RefCell};
use std::fmt::{self, Debug, Formatter};
use std::marker::PhantomData;
use std::ops::Deref;
use std::ptr::NonNull;

/// [`ipc::Service`] with pooled reference counts.
#[derive(Clone, Debug)]
pub struct PooledIpc {}

impl Service for PooledIpc {
    type ServiceNameHasher = <ipc::Service as Service>::ServiceNameHasher;
    type StaticStorage = <ipc::Service as Service>::StaticStorage;
    type ConfigSerializer = <ipc::Service as Service>::ConfigSerializer;
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> =
        <ipc::Service as Service>::PersistentDynamicStorage<T>;
    type Bag = <ipc::Service as Service>::Bag;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> =
        <ipc::Service as Service>::DynamicStorage<T>;
    type SharedMemory = <ipc::Service as Service>::SharedMemory;
    type ResizableSharedMemory = <ipc::Service as Service>::ResizableSharedMemory;
    type Connection = <ipc::Service as Service>::Connection;
    type Event = <ipc::Service as Service>::Event;
    type Monitoring = <ipc::Service as Service>::Monitoring;
    type Reactor = <ipc::Service as Service>::Reactor;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> = Pooled<T>;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> =
        <ipc::Service as Service>::BlackboardMgmt<T>;
    type BlackboardPayload = <ipc::Service as Service>::BlackboardPayload;
    type UniqueId = <ipc::Service as Service>::UniqueId;
}

impl ServiceInternal<Self> for PooledIpc {}

/// Unused blocks that a thread keeps.
const KEPT: usize = 32;

/// Blocks that were used and are free, with their layouts.
struct Free(Vec<(Layout, NonNull<u8>)>);

impl Drop for Free {
    fn drop(&mut self) {
        for (layout, block) in self.0.drain(..) {
            // SAFETY: `block_of` had it from the allocator with this layout, and it is free.
            unsafe { dealloc(block.as_ptr(), layout) };
        }
    }
}

thread_local! {
    static FREE: RefCell<Free> = RefCell::new(Free(Vec::with_capacity(KEPT)));
}

/// A block of `layout`, which is not of size 0; `None` if the allocator has no memory.
fn block_of(layout: Layout) -> Option<NonNull<u8>> {
    let used = FREE.try_with(|free| {
        let blocks = &mut free.borrow_mut().0;
        let index = blocks.iter().position(|(known, _)| *known == layout)?;
        Some(blocks.swap_remove(index).1)
    });
    // SAFETY: the layout is not of size 0.
    used.ok().flatten().or_else(|| NonNull::new(unsafe { alloc(layout) }))
}

/// Keeps a free block for later, or gives it back to the allocator.
fn give_back(block: NonNull<u8>, layout: Layout) {
    let kept = FREE.try_with(|free| {
        let blocks = &mut free.borrow_mut().0;
        let room = blocks.len() < KEPT;
        if room {
            blocks.push((layout, block));
        }
        room
    });
    if !kept.unwrap_or(false) {
        // SAFETY: the caller had it from `block_of` with this layout, and uses it no more.
        unsafe { dealloc(block.as_ptr(), layout) };
    }
}

struct Counted<T> {
    handles: Cell<usize>,
    value: T,
}

/// One of several handles of a value, all in one thread. The memory is used again after the last one.
pub struct Pooled<T>(NonNull<Counted<T>>, PhantomData<Counted<T>>);

impl<T> Pooled<T> {
    fn counted(&self) -> &Counted<T> {
        // SAFETY: the value lives as long as there is a handle.
        unsafe { self.0.as_ref() }
    }
}

impl<T> Clone for Pooled<T> {
    fn clone(&self) -> Self {
        let handles = &self.counted().handles;
        handles.set(handles.get() + 1);
        Self(self.0, PhantomData)
    }
}

impl<T> Drop for Pooled<T> {
    fn drop(&mut self) {
        let left = self.counted().handles.get() - 1;
        self.counted().handles.set(left);
        if left == 0 {
            // SAFETY: this was the last handle, and the block came from `block_of` with this layout.
            unsafe { self.0.drop_in_place() };
            give_back(self.0.cast(), Layout::new::<Counted<T>>());
        }
    }
}

impl<T: Debug> Debug for Pooled<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.counted().value.fmt(f)
    }
}

impl<T: Send + Debug + Abandonable> Abandonable for Pooled<T> {
    unsafe fn abandon_in_place(mut this: NonNull<Self>) {
        // SAFETY: the caller has the only reference to this handle, and does not use it again.
        let this = unsafe { this.as_mut() };
        if this.counted().handles.get() == 1 {
            // SAFETY: there is no other handle.
            unsafe { T::abandon_in_place(NonNull::from_mut(&mut this.0.as_mut().value)) };
        } else {
            // SAFETY: the caller does not use this handle again.
            unsafe { std::ptr::drop_in_place(this) };
        }
    }
}

/// Access to the value of a handle.
#[derive(Debug)]
pub struct Access<'a, T>(&'a T);

impl<T> Deref for Access<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0
    }
}

impl<'a, T: Send + Debug + Abandonable> LockGuard<'a, T> for Access<'a, T> {}

impl<T: Send + Debug + Abandonable> ArcSyncPolicy<T> for Pooled<T> {
    type LockGuard<'a>
        = Access<'a, T>
    where
        Self: 'a,
        T: 'a;

    fn new(value: T) -> Result<Self, ArcSyncPolicyCreationError> {
        let block = block_of(Layout::new::<Counted<T>>());
        let block = block.ok_or(ArcSyncPolicyCreationError::InsufficientResources)?;
        let counted: NonNull<Counted<T>> = block.cast();
        // SAFETY: the block has this layout and holds no value.
        unsafe { counted.write(Counted { handles: Cell::new(1), value }) };
        Ok(Self(counted, PhantomData))
    }

    fn lock(&self) -> Access<'_, T> {
        Access(&self.counted().value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[derive(Debug)]
    struct Value(Arc<AtomicU32>, [u64; 5]);

    impl Abandonable for Value {
        unsafe fn abandon_in_place(_: NonNull<Self>) {}
    }

    impl Drop for Value {
        fn drop(&mut self) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn value(dropped: &Arc<AtomicU32>, number: u64) -> Pooled<Value> {
        Pooled::new(Value(Arc::clone(dropped), [number; 5])).expect("memory")
    }

    #[test]
    fn a_value_lives_until_its_last_handle_is_gone_and_is_dropped_once() {
        let dropped = Arc::new(AtomicU32::new(0));
        let first = value(&dropped, 7);
        let second = first.clone();
        drop(first);
        assert_eq!((second.lock().1, dropped.load(Ordering::Relaxed)), ([7; 5], 0));
        drop(second);
        assert_eq!(dropped.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn memory_is_used_again_and_never_by_two() {
        let dropped = Arc::new(AtomicU32::new(0));
        let first = value(&dropped, 1);
        let place = first.0;
        drop(first);
        let again = value(&dropped, 2);
        assert_eq!(again.0, place);
        let beside = value(&dropped, 3);
        assert_ne!(beside.0, place);
        assert_eq!((again.lock().1, beside.lock().1), ([2; 5], [3; 5]));
        // More than are kept.
        let many: Vec<_> = (0..2 * KEPT as u64).map(|k| value(&dropped, k)).collect();
        drop(many);
        drop((again, beside));
        assert_eq!(dropped.load(Ordering::Relaxed), 3 + 2 * KEPT as u32);
    }

    #[test]
    fn a_handle_outlives_the_pool_of_its_thread() {
        thread_local! {
            static KEPT_LONG: RefCell<Option<Pooled<Value>>> = const { RefCell::new(None) };
        }
        let dropped = Arc::new(AtomicU32::new(0));
        let inside = Arc::clone(&dropped);
        let thread = std::thread::spawn(move || {
            // Made before the pool, so that it is dropped after it.
            KEPT_LONG.with_borrow_mut(|kept| *kept = None);
            KEPT_LONG.with_borrow_mut(|kept| *kept = Some(value(&inside, 1)));
        });
        thread.join().expect("no panic");
        assert_eq!(dropped.load(Ordering::Relaxed), 1);
    }
}
