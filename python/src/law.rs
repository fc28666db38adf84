//! A law in Python: a callable, with an optional `reset`.

use crate::answer;
use crate::question::Question;
use controller::laws::external::Questions;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

/// A law.
#[pyclass(frozen, module = "timegap._timegap")]
pub struct Law {
    call: Py<PyAny>,
    reset: Option<Py<PyAny>>,
    name: String,
}

/// An exception that is not an answer to a question. It goes to the caller that started the run.
pub struct Raised(pub PyErr);

impl Law {
    /// The law `name`.
    pub fn new(law: &Bound<'_, PyAny>, name: String) -> PyResult<Self> {
        let reset = law.getattr_opt("reset")?.filter(Bound::is_callable);
        Ok(Self { call: law.clone().unbind(), reset: reset.map(Bound::unbind), name })
    }

    /// Answers the question that is open. An exception of the law ends the run, with its traceback; `failed` keeps it.
    pub fn answer(
        &self,
        py: Python<'_>,
        questions: &Questions,
        failed: &mut Option<PyErr>,
    ) -> Result<(), Raised> {
        let Some(question) = questions.question() else { return Ok(()) };
        let forgets = question.reset == 1;
        let ask = || {
            if let Some(reset) = self.reset.as_ref().filter(|_| forgets) {
                reset.call0(py)?;
            }
            let question = Bound::new(py, Question::new(question))?;
            answer::of(self.call.bind(py).call1((question,))?.as_any(), &self.name)
        };
        match ask() {
            Ok(answer) => questions.answer(answer),
            Err(error) if error.is_instance_of::<PyException>(py) => {
                questions.fail(traceback(py, &error));
                *failed = Some(error);
            }
            // KeyboardInterrupt, SystemExit.
            Err(error) => return Err(Raised(error)),
        }
        Ok(())
    }
}

/// The traceback of an error, as Python prints it.
fn traceback(py: Python<'_>, error: &PyErr) -> String {
    let printed = || -> PyResult<String> {
        let lines = py.import("traceback")?.call_method1(
            "format_exception",
            (error.get_type(py), error.value(py), error.traceback(py)),
        )?;
        Ok(lines.extract::<Vec<String>>()?.concat().trim_end().to_owned())
    };
    printed().unwrap_or_else(|_| error.to_string())
}
