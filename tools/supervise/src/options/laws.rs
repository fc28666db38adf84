//! Laws of the user's own on the command line.

use crate::UsageError;
use clap::Args;
use scenario::name::Name;
use scenario::{Overrides, Setting};
use serde::{Deserialize, Serialize};

/// Laws of the user's own, by the option `--law`.
///
/// ```
/// use supervise::LawOptions;
///
/// let law = "gentle=python3 law.py --gain 0.3".parse().unwrap();
/// let laws = LawOptions { laws: vec![law] };
/// assert_eq!(laws.names(), ["gentle"]);
/// ```
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize)]
pub struct LawOptions {
    /// A law of your own: starts a program, with words as in a shell; or asks a ROS 2 node, `NAME=ros2:[DOMAIN]`
    /// (repeatable)
    #[arg(long = "law", value_name = "NAME=COMMAND")]
    pub laws: Vec<NamedLaw>,
}

/// A law of the user's own with its name: `NAME=COMMAND`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedLaw {
    /// Its name in rows, legends and JSON.
    pub name: String,
    /// What computes it.
    pub source: LawSource,
}

/// What computes a law of the user's own.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawSource {
    Program(Vec<String>),
    /// The program that starts the run.
    Caller,
}

impl std::str::FromStr for NamedLaw {
    type Err = UsageError;

    fn from_str(argument: &str) -> Result<Self, UsageError> {
        let error =
            |what: &str, why, expected| UsageError::at(format_args!("`{what}`"), why, expected);
        let (name, command) =
            argument.split_once('=').ok_or_else(|| error(argument, "no `=`", "NAME=COMMAND"))?;
        let no_name = |_| error(name, "not a name", "1 to 64 letters, digits, `-` or `_`");
        let of_law = String::from(Name::try_from(name.to_owned()).map_err(no_name)?);
        if controller::laws::find(name).is_some() {
            return Err(error(name, "a law of timegap's own", "another name"));
        }
        let words = match command.strip_prefix("ros2:") {
            Some(domain) if domain.is_empty() || domain.parse().is_ok_and(|n: u8| n <= 232) => {
                Some(relay(domain))
            }
            Some(_) => return Err(error(command, "not a domain", "ros2:[DOMAIN], from 0 to 232")),
            None => shlex::split(command).filter(|words| !words.is_empty()),
        };
        let words = words.ok_or_else(|| error(command, "not a command", "words as in a shell"))?;
        Ok(Self { name: of_law, source: LawSource::Program(words) })
    }
}

/// The program that asks a ROS 2 node: this one again.
fn relay(domain: &str) -> Vec<String> {
    let program = std::env::current_exe().unwrap_or_else(|_| "timegap".into());
    [&program.to_string_lossy(), "service", "ros2-law", domain].map(str::to_owned).into()
}

impl LawOptions {
    /// The names, in the order of the options.
    pub fn names(&self) -> Vec<String> {
        self.laws.iter().map(|law| law.name.clone()).collect()
    }

    /// The only law, if there is one.
    pub fn only(&self) -> Option<&str> {
        match self.laws.as_slice() {
            [law] => Some(&law.name),
            _ => None,
        }
    }

    /// Refuses a name that two laws have.
    pub fn check(&self) -> Result<(), UsageError> {
        let twice = |(place, law): &(usize, &NamedLaw)| {
            self.laws[..*place].iter().any(|known| known.name == law.name)
        };
        match self.laws.iter().enumerate().find(twice) {
            Some((_, law)) => {
                let why = "the name is given twice";
                Err(UsageError::option("--law", &law.name, why, "a name for each law"))
            }
            None => Ok(()),
        }
    }

    /// Refuses a law that is not among those that drive.
    pub fn expect_all_in(&self, driving: &[impl AsRef<str>]) -> Result<(), UsageError> {
        let driving: Vec<&str> = driving.iter().map(AsRef::as_ref).collect();
        match self.laws.iter().find(|law| !driving.contains(&law.name.as_str())) {
            Some(NamedLaw { name, .. }) => {
                let driving = driving.join(", ");
                let expected = format_args!("`{name}` among the controllers, which are {driving}");
                Err(UsageError::option("--law", name, "no run is driven by it", expected))
            }
            None => Ok(()),
        }
    }

    /// The options as words of a command line.
    ///
    /// ```
    /// # use supervise::LawOptions;
    /// let laws = LawOptions { laws: vec!["a=python3 'my law.py'".parse().unwrap()] };
    /// assert_eq!(laws.words(), ["--law", "a=python3 'my law.py'"]);
    /// ```
    pub fn words(&self) -> Vec<String> {
        let words = self.laws.iter().filter_map(|NamedLaw { name, source }| {
            let source = match source {
                LawSource::Program(words) => runtime::command_line(words),
                LawSource::Caller => return None,
            };
            Some(["--law".to_owned(), format!("{name}={source}")])
        });
        words.flatten().collect()
    }

    /// The keys that declare the laws. Their programs run in the present directory.
    pub fn settings(&self) -> Vec<Setting> {
        let here = std::env::current_dir().unwrap_or_default();
        let each = |NamedLaw { name, source }: &NamedLaw| {
            let key = |key: &str| format!("laws.{name}.{key}");
            match source {
                LawSource::Program(words) => vec![
                    Setting::new(&key("command"), words.clone()),
                    Setting::new(&key("directory"), here.to_string_lossy().as_ref()),
                ],
                LawSource::Caller => vec![Setting::new(&key("caller"), true)],
            }
        };
        self.laws.iter().flat_map(each).collect()
    }

    /// Declares the laws in a scenario, on behalf of the option that errors name.
    pub fn lay_over(&self, option: &'static str, overrides: &mut Overrides) {
        self.settings().into_iter().for_each(|setting| overrides.set_by(option, setting));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(argument: &str) -> Result<NamedLaw, UsageError> {
        argument.parse()
    }

    #[test]
    fn a_command_is_split_as_a_shell_does() {
        let words = |argument| match law(argument).expect("a law").source {
            LawSource::Program(words) => words,
            other => panic!("{other:?}"),
        };
        assert_eq!(words("a=python3 'my law.py' --k=1"), ["python3", "my law.py", "--k=1"]);
        assert_eq!(words("a=ros2:7")[1..], ["service", "ros2-law", "7"]);
        assert_eq!(words("a=ros2:")[3], "", "the environment says which domain");
    }

    #[test]
    fn an_argument_that_is_not_a_law_is_refused_with_what_was_expected() {
        for (argument, what) in [
            ("gentle", "expected NAME=COMMAND"),
            ("a b=./law", "not a name"),
            ("=./law", "not a name"),
            ("six-mode=./law", "a law of timegap's own"),
            ("a=", "not a command"),
            ("a='./law", "not a command"),
            ("a=ros2:233", "not a domain"),
            ("a=ros2:here", "ros2:[DOMAIN], from 0 to 232"),
        ] {
            let said = law(argument).expect_err(argument).to_string();
            assert!(said.contains(what) && said.contains("expected"), "{said}");
        }
        let laws = LawOptions { laws: vec![law("a=x").expect("good"), law("a=y").expect("good")] };
        let said = laws.check().expect_err("a name of two").to_string();
        assert!(said.starts_with("--law a: the name is given twice"), "{said}");
        assert_eq!(laws.only(), None);
        let laws = LawOptions { laws: vec![law("a=x").expect("good")] };
        assert_eq!(laws.expect_all_in(&["acc-mpc", "a"]), Ok(()));
        let said = laws.expect_all_in(&["acc-mpc"]).expect_err("unused").to_string();
        assert!(said.ends_with("expected `a` among the controllers, which are acc-mpc"), "{said}");
    }
}
