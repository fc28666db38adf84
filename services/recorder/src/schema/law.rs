//! Questions to a foreign law and its answers, in Python and in C: `timegap print layouts --law`.

use super::{c, collect, python};
use messages::{LAW_RECORDS, LAYOUT_VERSION, Layout};

/// Head of a law's program in Python.
const DRIVE: &str = r#"

def drive(law):
    """Answers every question until the run ends.

    `law(question)` returns the requested acceleration in m/s², or a LawAnswer. Standard output is for
    the answers: print() goes to standard error.
    """
    questions, answers = sys.stdin.buffer, sys.stdout.buffer
    sys.stdout = sys.stderr
    size = ctypes.sizeof(LawInput)
    while len(record := questions.read(size)) == size:
        question = LawInput.from_buffer_copy(record)
        answer = law(question)
        if not isinstance(answer, LawAnswer):
            answer = LawAnswer(request_mps2=answer)
        answer.sequence = question.sequence
        answers.write(bytes(answer))
        answers.flush()
"#;

/// The two records and what they are made of, each after what it contains.
pub fn all() -> Vec<&'static Layout> {
    let mut found = Vec::new();
    LAW_RECORDS.into_iter().for_each(|layout| collect(layout, &mut found));
    found
}

/// A Python module with both records as `ctypes` structures, and the loop around a law.
pub fn python_module() -> String {
    let classes: String = all().into_iter().map(python::class).collect();
    format!(
        "\"\"\"Questions and answers of a law for timegap, layout version {LAYOUT_VERSION}: made by \
         `timegap print layouts --law --python`.\n\nA whole law:\n\n    import timegap_law\n    \
         timegap_law.drive(lambda q: 0.4 * (q.set_speed_mps - q.speed_mps))\n\"\"\"\n\nimport \
         ctypes\nimport sys\n\nLAYOUT_VERSION = \"{LAYOUT_VERSION}\"\n{classes}{DRIVE}"
    )
}

/// A C11 header with both records.
pub fn c_header() -> String {
    let structures: String = all().into_iter().map(c::structure).collect();
    format!(
        "/* Questions and answers of a law for timegap, layout version {LAYOUT_VERSION}: made by\n   \
         `timegap print layouts --law --c`. The program reads TimegapLawInput from its standard input and\n   \
         writes one TimegapLawAnswer with the same sequence number to its standard output. */\n\
         #ifndef TIMEGAP_LAW_H\n#define TIMEGAP_LAW_H\n\n#include <assert.h>\n#include \
         <stddef.h>\n#include <stdint.h>\n\n#define TIMEGAP_LAYOUT_VERSION \
         \"{LAYOUT_VERSION}\"\n{structures}\n#endif\n"
    )
}
