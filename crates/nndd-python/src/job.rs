//! Work on threads of its own, while the thread that called waits, runs callbacks and looks for signals.

use crate::errors::{exception, wrong};
use crate::json::loads;
use nndd_report::failure::{self, Failure};
use nndd_report::memory_limit;
use nndd_report::{Deadline, Event, Host, MemoryLimit, adaptive_row, report, without_bound};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// How often signals are looked for.
const POLL: Duration = Duration::from_millis(50);
/// Most threads, as for the command.
const MOST_THREADS: usize = 1024;
/// The stack of each thread, bytes: as large as the main thread's.
const STACK: usize = 8 << 20;
/// The exit status of the command after Ctrl-C.
const INTERRUPTED: u8 = 130;

/// A piece of Python that the calling thread runs for the work.
type Call = Box<dyn FnOnce(Python<'_>) -> PyResult<()> + Send>;

/// A message from the work to the calling thread.
enum Message<T> {
    Event(Value),
    Call(Call),
    Done(Result<T, Failure>),
}

/// Brings a call to the thread that called.
type Asker = Box<dyn Fn(Call)>;

thread_local! {
    /// On the thread of some work: how to ask the thread that called.
    static ASK: RefCell<Option<Asker>> = const { RefCell::new(None) };
}

/// Lets the thread that called do something and waits for it; `None` if it raised, which ends the work, or is not there any more.
pub(crate) fn ask<R: Send + 'static>(
    what: impl FnOnce(Python<'_>) -> PyResult<R> + Send + 'static,
) -> Option<R> {
    let (answer, answered) = channel();
    let call: Call = Box::new(move |py| {
        // The work waits as long as this exists.
        let _ = answer.send(what(py)?);
        Ok(())
    });
    ASK.with_borrow(|ask| ask.as_ref().map(|ask| ask(call)));
    answered.recv().ok()
}

/// A part of the program around a run that the thread that called sees too.
#[derive(Default)]
struct Shared {
    interrupted: AtomicBool,
    deadline: Deadline,
}

/// The program around a run, as the work sees it.
pub(crate) struct Caller {
    started: Instant,
    shared: Arc<Shared>,
    tell: Option<Box<dyn Fn(Value) + Send>>,
}

impl Host for Caller {
    fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    fn interrupted(&self) -> Option<u8> {
        self.shared.interrupted.load(Ordering::Relaxed).then_some(INTERRUPTED)
    }

    fn memory_limit(&self) -> Option<MemoryLimit> {
        memory_limit::smallest(rayon::current_num_threads())
    }

    fn begins(&self, step: &'static str, limit: Option<f64>) {
        self.shared.deadline.begin(step, limit);
    }

    fn event(&mut self, event: Event<'_>) -> Result<(), Failure> {
        self.shared.deadline.follow(&event);
        if let Some(tell) = &self.tell
            && let Some(value) = described(&event)
        {
            tell(value);
        }
        Ok(())
    }
}

/// Makes what a callback gets of an event; `None` for events that it is not told.
fn described(event: &Event<'_>) -> Option<Value> {
    let (kind, mut value) = match event {
        Event::Iteration(row) => ("iteration", json!(report::iteration_row(row))),
        Event::Step(step) => {
            ("mesh", adaptive_row(step).map_or_else(|| without_bound(step), |row| json!(row)))
        }
        Event::LoadStep { step, of } => ("load_step", json!({ "step": step.step, "of": of })),
        Event::Value { value, status, .. } => ("value", json!({ "value": value, "status": status.word })),
        _ => return None,
    };
    value.as_object_mut()?.insert("event".into(), kind.into());
    Some(value)
}

/// Does some work on new threads, without the lock on the interpreter. Each call has its own threads: a fork leaves none behind
/// that a later call would wait for.
///
/// After the first Ctrl-C the work ends with what it has; after the second it is left alone, as it is at the time limit if it has no result. An exception of a callback, a function or another
/// handler of a signal ends the work, and passes through.
///
/// * `threads`: 0 for one per core, or as many as `RAYON_NUM_THREADS` says.
/// * `callback`: is told of each event; the work ends if it raises.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    callback: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut Caller) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    if threads > MOST_THREADS {
        let found = threads.to_string();
        return Err(wrong(
            py,
            Some("threads"),
            &found,
            "a whole number from 0 to 1024",
            "lower it, or leave it out",
        ));
    }
    let (started, shared) = (Instant::now(), Arc::<Shared>::default());
    let (sender, receiver) = channel();
    let caller = Caller {
        started,
        shared: Arc::clone(&shared),
        tell: callback.is_some().then(|| teller(sender.clone())),
    };
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
    let pool = pool.map_err(|error| {
        let said = format!(
            "cannot start the threads: {error}\n  expected: threads to compute with\n  fix: ask for fewer"
        );
        exception(py, &Failure::plain(failure::FILES, said))
    })?;
    pool.spawn(move || {
        let mut caller = caller;
        let asker = sender.clone();
        ASK.set(Some(Box::new(move |call| {
            let _ = asker.send(Message::Call(call));
        })));
        let done = catch_unwind(AssertUnwindSafe(|| work(&mut caller))).unwrap_or_else(|_| {
            Err(Failure::plain(failure::DEFECT, "a defect of this program: it panicked, see standard error"))
        });
        ASK.set(None);
        // Nobody listens after the second Ctrl-C, or the time limit.
        let _ = sender.send(Message::Done(done));
    });
    wait(py, receiver, (started, &shared), callback)
}

fn teller<T: Send + 'static>(sender: Sender<Message<T>>) -> Box<dyn Fn(Value) + Send> {
    Box::new(move |value| {
        let _ = sender.send(Message::Event(value));
    })
}

/// Waits for the result.
fn wait<T: Send>(
    py: Python<'_>,
    mut receiver: Receiver<Message<T>>,
    (started, shared): (Instant, &Shared),
    callback: Option<&Bound<'_, PyAny>>,
) -> PyResult<T> {
    // The first exception of a callback, of a function or of another handler of a signal.
    let mut raised = None;
    let mut by_signal = false;
    loop {
        let (message, returned) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
        receiver = returned;
        let said = match message {
            Ok(Message::Event(value)) if raised.is_none() => {
                callback.map_or(Ok(()), |callback| callback.call1((loads(py, &value)?,)).map(|_| ()))
            }
            Ok(Message::Call(call)) if raised.is_none() => call(py),
            Ok(Message::Event(_) | Message::Call(_)) | Err(RecvTimeoutError::Timeout) => Ok(()),
            Ok(Message::Done(done)) => {
                return match (raised, done) {
                    (Some(raised), _) => Err(raised),
                    (None, Ok(found)) => Ok(found),
                    (None, Err(_)) if by_signal => Err(PyKeyboardInterrupt::new_err(())),
                    (None, Err(failure)) => Err(exception(py, &failure)),
                };
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(exception(
                    py,
                    &Failure::plain(failure::DEFECT, "the work ended without a result"),
                ));
            }
        };
        if let Some(failure) = shared.deadline.exceeded(started.elapsed().as_secs_f64()) {
            shared.interrupted.store(true, Ordering::Relaxed);
            return Err(exception(py, &failure));
        }
        for error in [said, py.check_signals()].into_iter().filter_map(Result::err) {
            let is_signal = error.is_instance_of::<PyKeyboardInterrupt>(py);
            let is_first = !shared.interrupted.swap(true, Ordering::Relaxed);
            if is_signal && !is_first {
                return Err(error);
            }
            by_signal |= is_signal;
            if !is_signal {
                raised.get_or_insert(error);
            }
        }
    }
}
