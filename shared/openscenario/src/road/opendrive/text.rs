//! Numbers and errors of a file, as OpenDRIVE and SUMO write them.

use road::Stretch;

use crate::error::{Place, ReadError};
use crate::xml::Element;

/// Largest factor of a cubic: with a larger one a height or a width might not be finite.
const MAX_FACTOR: f64 = 1e6;

/// The file that errors name.
#[derive(Clone, Copy, Debug)]
pub struct Text<'a> {
    pub file: &'a str,
}

impl Text<'_> {
    pub fn number(&self, element: &Element, attribute: &str) -> Result<f64, ReadError> {
        let text = element.attribute(attribute).unwrap_or_default();
        text.trim().parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
            let place = match element.given(attribute) {
                Some(given) => Place { file: self.file.to_owned(), spot: given.spot },
                None => self.place(element),
            };
            let reason = match element.attribute(attribute) {
                Some(text) => format!("`{text}` is not a number"),
                None => "it is missing".to_owned(),
            };
            ReadError::attribute(place, (attribute, &element.name), reason, "a number")
        })
    }

    pub fn numbers<const N: usize>(
        &self,
        element: &Element,
        attributes: [&str; N],
    ) -> Result<[f64; N], ReadError> {
        let mut numbers = [0.0; N];
        for (number, attribute) in numbers.iter_mut().zip(attributes) {
            *number = self.number(element, attribute)?;
        }
        Ok(numbers)
    }

    /// A whole number, such as a lane's id.
    pub fn whole(&self, element: &Element, attribute: &str) -> Result<i32, ReadError> {
        let number = self.number(element, attribute)?;
        if number != number.trunc() || number.abs() > f64::from(i32::MAX) {
            let reason = format!("`{attribute}` of `{}` is {number}", element.name);
            return Err(self.meaning(element, reason, "a whole number"));
        }
        Ok(number as i32)
    }

    /// The cubic of an element with `a`, `b`, `c` and `d`. It counts from `start` on of the part that begins at
    /// `from_m`.
    pub fn stretch(
        &self,
        element: &Element,
        start: &str,
        from_m: f64,
    ) -> Result<Stretch, ReadError> {
        let at_m = self.number(element, start)?;
        if at_m < 0.0 {
            let reason = format!("`{start}` of `{}` is {at_m}", element.name);
            return Err(self.meaning(element, reason, "at least 0"));
        }
        let factors = self.numbers(element, ["a", "b", "c", "d"])?;
        if let Some(factor) = factors.iter().find(|factor| factor.abs() > MAX_FACTOR) {
            let reason = format!("`{}` has the factor {factor}", element.name);
            return Err(self.meaning(element, reason, format!("at most {MAX_FACTOR}")));
        }
        Ok(Stretch { from_m: from_m + at_m, factors })
    }

    pub fn place(&self, element: &Element) -> Place {
        Place { file: self.file.to_owned(), spot: element.spot }
    }

    pub fn element(
        &self,
        element: &Element,
        parent: &str,
        fault: &str,
        expected: &str,
    ) -> ReadError {
        ReadError::element(self.place(element), (&element.name, parent), fault, expected)
    }

    pub fn meaning(
        &self,
        element: &Element,
        reason: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        ReadError::meaning(self.place(element), reason, expected)
    }
}

pub fn children<'a>(element: &'a Element, name: &'a str) -> impl Iterator<Item = &'a Element> {
    element.children.iter().filter(move |child| child.name == name)
}
