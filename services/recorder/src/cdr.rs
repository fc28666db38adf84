//! Little-endian CDR, as ROS 2 writes it. Each scalar stands on a multiple of its size, counted
//! from behind the four bytes of encapsulation.

/// Little-endian CDR without options: what precedes every body.
pub(crate) const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message that is being written.
#[derive(Debug)]
pub(crate) struct Cdr(Vec<u8>);

impl Cdr {
    pub(crate) fn new() -> Self {
        Self(ENCAPSULATION.to_vec())
    }

    pub(crate) fn finish(self) -> Vec<u8> {
        self.0
    }

    fn scalar<const N: usize>(&mut self, bytes: [u8; N]) -> &mut Self {
        let body = self.0.len() - ENCAPSULATION.len();
        self.0.resize(ENCAPSULATION.len() + body.next_multiple_of(N), 0);
        self.0.extend_from_slice(&bytes);
        self
    }

    pub(crate) fn u8(&mut self, value: u8) -> &mut Self {
        self.scalar([value])
    }

    pub(crate) fn u32(&mut self, value: u32) -> &mut Self {
        self.scalar(value.to_le_bytes())
    }

    pub(crate) fn i32(&mut self, value: i32) -> &mut Self {
        self.scalar(value.to_le_bytes())
    }

    pub(crate) fn f32(&mut self, value: f32) -> &mut Self {
        self.scalar(value.to_le_bytes())
    }

    pub(crate) fn f64(&mut self, value: f64) -> &mut Self {
        self.scalar(value.to_le_bytes())
    }

    /// The number of elements that follow.
    pub(crate) fn count(&mut self, count: usize) -> &mut Self {
        self.u32(u32::try_from(count).expect("few"))
    }

    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        self.count(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.u8(0)
    }

    pub(crate) fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.extend_from_slice(bytes);
        self
    }

    /// `std_msgs/Header`.
    pub(crate) fn header(&mut self, unix_ns: i64, frame: &str) -> &mut Self {
        self.stamp(unix_ns).text(frame)
    }

    /// `builtin_interfaces/Time`.
    pub(crate) fn stamp(&mut self, unix_ns: i64) -> &mut Self {
        let (s, ns) = (unix_ns.div_euclid(1_000_000_000), unix_ns.rem_euclid(1_000_000_000));
        self.i32(i32::try_from(s).unwrap_or(i32::MAX));
        self.u32(u32::try_from(ns).expect("less than a second"))
    }

    pub(crate) fn point(&mut self, [x, y, z]: [f64; 3]) -> &mut Self {
        self.f64(x).f64(y).f64(z)
    }

    /// A rotation about the vertical axis, as a quaternion.
    pub(crate) fn turned(&mut self, heading_rad: f64) -> &mut Self {
        let (sine, cosine) = libm::sincos(0.5 * heading_rad);
        self.point([0.0, 0.0, sine]).f64(cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scalars_are_aligned_behind_the_encapsulation() {
        let mut cdr = Cdr::new();
        cdr.u8(7).f64(1.0).text("ab").u32(9);
        let expected = [
            &[0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0][..],
            &1.0_f64.to_le_bytes(),
            &[3, 0, 0, 0, b'a', b'b', 0, 0],
            &[9, 0, 0, 0],
        ]
        .concat();
        assert_eq!(cdr.finish(), expected);
    }
}
