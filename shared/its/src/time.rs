//! Times in the messages.
//!
//! | here | standard |
//! |---|---|
//! | [`UnixMs`] | milliseconds of UTC since 1970, without leap seconds |
//! | [`its_timestamp`] | `TimestampIts`: milliseconds since 2004-01-01 with leap seconds (ETSI TS 102 894-2) |
//! | [`Stamp`] | `MinuteOfTheYear` and `DSecond` of an `IntersectionState` |
//! | [`TimeMark`] | `TimeMark`: tenths of a second in the present or next hour of UTC |

/// Milliseconds of UTC since 1970-01-01, without leap seconds.
pub type UnixMs = i64;

const MINUTE_MS: i64 = 60_000;
const HOUR_MS: i64 = 3_600_000;
const DAY_MS: i64 = 86_400_000;
/// 2004-01-01T00:00:00Z.
const ITS_EPOCH_MS: i64 = 1_072_915_200_000;
/// Leap seconds from 2004 to the latest one, of 2016.
const LEAP_MS: i64 = 5_000;

/// Milliseconds since the epoch of ITS, 2004-01-01, by atomic time.
pub fn its_timestamp(utc: UnixMs) -> i64 {
    utc - ITS_EPOCH_MS + LEAP_MS
}

/// The UTC of a timestamp modulo `modulus` ms, nearest to `near`.
pub fn from_its_timestamp(modulo: i64, modulus: i64, near: UnixMs) -> UnixMs {
    let near_its = its_timestamp(near);
    let half = modulus / 2;
    let ahead = (modulo - near_its).rem_euclid(modulus);
    near + if ahead > half { ahead - modulus } else { ahead }
}

/// Minute of the year and millisecond of the minute.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stamp {
    /// Minute of the year in UTC, 0 to 527039.
    pub minute_of_year: u32,
    /// Millisecond of the minute, 0 to 60999 (a leap second).
    pub millisecond: u16,
}

impl Stamp {
    pub fn of(utc: UnixMs) -> Self {
        let into_year = utc - year_start(year_of(utc));
        let minute = into_year.div_euclid(MINUTE_MS);
        let millisecond = into_year.rem_euclid(MINUTE_MS);
        Self { minute_of_year: minute as u32, millisecond: millisecond as u16 }
    }

    /// Its UTC, in the year nearest to `near`.
    pub fn utc(self, near: UnixMs) -> UnixMs {
        let into_year = i64::from(self.minute_of_year) * MINUTE_MS + i64::from(self.millisecond);
        let year = year_of(near);
        [year - 1, year, year + 1]
            .map(|year| year_start(year) + into_year)
            .into_iter()
            .min_by_key(|utc| (utc - near).abs())
            .expect("there are three")
    }
}

/// Largest age of a time mark for its reader, ms; the rest of the hour is ahead.
const PAST_MS: i64 = 60_000;

/// Tenths of a second in the present or next hour.
///
/// ```
/// use its::time::TimeMark;
///
/// let now_ms = 1_780_315_170_000;
/// let red_ends = TimeMark::of(now_ms + 12_345, now_ms);
/// assert_eq!(red_ends.utc(now_ms), Some(now_ms + 12_300), "to a tenth of a second");
/// assert_eq!(TimeMark::UNKNOWN.utc(now_ms), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TimeMark(u16);

impl Default for TimeMark {
    fn default() -> Self {
        Self::UNKNOWN
    }
}

impl TimeMark {
    /// More than an hour ahead.
    pub const BEYOND: Self = Self(36_000);
    pub const UNKNOWN: Self = Self(36_001);

    /// The mark of a time, rounded to a tenth of a second, in a message sent at `now`.
    pub fn of(utc: UnixMs, now: UnixMs) -> Self {
        if utc - now >= HOUR_MS - PAST_MS {
            return Self::BEYOND;
        }
        Self(((utc + 50).rem_euclid(HOUR_MS) / 100) as u16)
    }

    /// The mark with this number, 0 to 36001; `None` for others.
    pub fn new(value: u16) -> Option<Self> {
        (value <= Self::UNKNOWN.0).then_some(Self(value))
    }

    /// Number in the message.
    pub fn value(self) -> u16 {
        self.0
    }

    /// Its UTC for a reader at `now`: up to a minute ago, or within the next hour. `None` if it is later or
    /// unknown.
    pub fn utc(self, now: UnixMs) -> Option<UnixMs> {
        if self.0 >= Self::BEYOND.0 {
            return None;
        }
        let from = now - PAST_MS;
        let mark = i64::from(self.0) * 100;
        Some(from + (mark - from).rem_euclid(HOUR_MS))
    }
}

/// Year of a time (days to civil, Hinnant's algorithm).
fn year_of(utc: UnixMs) -> i64 {
    let days = utc.div_euclid(DAY_MS) + 719_468;
    let era = days.div_euclid(146_097);
    let day = days.rem_euclid(146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day_of_year = day - (365 * year + year / 4 - year / 100);
    // Years of the algorithm begin in March.
    era * 400 + year + i64::from(day_of_year >= 306)
}

fn year_start(year: i64) -> UnixMs {
    let before = year - 1;
    let leap_days = before.div_euclid(4) - before.div_euclid(100) + before.div_euclid(400);
    (before * 365 + leap_days - 719_162) * DAY_MS
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn years_begin_where_the_calendar_says() {
        assert_eq!(year_start(1970), 0);
        assert_eq!(year_start(2004), ITS_EPOCH_MS);
        assert_eq!(year_start(2026), 1_767_225_600_000);
        for (utc, year) in [(0, 1970), (-1, 1969), (1_767_225_599_999, 2025)] {
            assert_eq!(year_of(utc), year);
        }
    }

    #[test]
    fn a_known_date_has_the_published_timestamp() {
        // EN 302 637-2: TimestampIts of 2007-01-01T00:00:00.000Z is 94694401000.
        assert_eq!(1_167_609_600_000 - ITS_EPOCH_MS + 1_000, 94_694_401_000);
        assert_eq!(its_timestamp(1_767_225_600_000), 694_310_405_000);
    }

    #[test]
    fn a_mark_wraps_at_the_hour() {
        let eleven_59_58 = year_start(2026) + 12 * HOUR_MS - 2_000;
        let mark = TimeMark::of(eleven_59_58 + 5_000, eleven_59_58);
        assert_eq!(mark.value(), 30);
        assert_eq!(mark.utc(eleven_59_58), Some(eleven_59_58 + 5_000));
        assert_eq!(mark.utc(eleven_59_58 + 7_000), Some(eleven_59_58 + 5_000), "2 s ago");
        assert_eq!(TimeMark::of(eleven_59_58 + HOUR_MS, eleven_59_58), TimeMark::BEYOND);
        assert_eq!(TimeMark::BEYOND.utc(0), None);
        assert_eq!(TimeMark::UNKNOWN.utc(0), None);
        assert_eq!(TimeMark::new(36_002), None);
    }

    proptest! {
        #[test]
        fn stamps_and_marks_come_back(
            utc in 1_072_915_200_000..4_000_000_000_000i64, ahead in -50_000..3_500_000i64,
            off in -100_000_000..100_000_000i64,
        ) {
            prop_assert_eq!(Stamp::of(utc).utc(utc + off), utc);
            prop_assert!(Stamp::of(utc).minute_of_year < 527_040);
            let mark = TimeMark::of(utc + ahead, utc).utc(utc).expect("within the hour");
            prop_assert!((mark - utc - ahead).abs() <= 50);
            let modulus = 1 << 32;
            let its = its_timestamp(utc).rem_euclid(modulus);
            prop_assert_eq!(from_its_timestamp(its, modulus, utc + off), utc);
        }
    }
}
