//! A private Slurm with one node, for array jobs.

use super::PROGRAM;
use rustix::process::{Pid, Signal, kill_process};
use std::process::{Child, Command, Stdio};
use system_tests::cases::{self, Needed};
use system_tests::missing::Missing;
use system_tests::{Corner, text, wait_for};

/// The daemons of a private Slurm.
pub struct Slurm {
    daemons: Vec<Child>,
    configuration: String,
}

impl Drop for Slurm {
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            // Asked first: a killed node leaves its steps behind.
            let pid = i32::try_from(daemon.id()).ok().and_then(Pid::from_raw);
            let _ = pid.map(|pid| kill_process(pid, Signal::TERM));
            let gone = wait_for(|| matches!(daemon.try_wait(), Ok(Some(_)) | Err(_)));
            if !gone {
                let _ = daemon.kill();
                let _ = daemon.wait();
            }
        }
    }
}

impl Slurm {
    /// One node, its controller and munge, with all files in a corner; or the reason why they do not start.
    pub fn start(corner: &Corner) -> Result<Self, Missing> {
        let base = corner.path().join("slurm");
        for directory in ["", "state", "spool"] {
            std::fs::create_dir_all(base.join(directory)).expect("our own directory");
        }
        let private = std::os::unix::fs::PermissionsExt::from_mode(0o700);
        std::fs::set_permissions(&base, private).expect("our own directory");
        let mut key = vec![0; 128];
        let mut random = std::fs::File::open("/dev/urandom").expect("it is there");
        std::io::Read::read_exact(&mut random, &mut key).expect("it has no end");
        std::fs::write(base.join("key"), key).expect("our own directory");
        let private = std::os::unix::fs::PermissionsExt::from_mode(0o600);
        std::fs::set_permissions(base.join("key"), private).expect("our own file");
        let free_port = || {
            let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
            listener.local_addr().expect("it is bound").port()
        };
        let (controller, node) = (free_port(), free_port());
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").expect("a name");
        let (host, at) = (host.trim(), base.display());
        let user = Command::new("id").arg("-un").output().expect("id");
        let user = String::from_utf8_lossy(&user.stdout).trim().to_owned();
        let text = format!(
            "ClusterName=own\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/munge\nAuthInfo=socket={at}/munge.socket\nCredType=cred/munge\n\
             SlurmctldPort={controller}\nSlurmdPort={node}\nStateSaveLocation={at}/state\n\
             SlurmdSpoolDir={at}/spool\nSlurmctldPidFile={at}/controller.pid\n\
             SlurmdPidFile={at}/node.pid\nSlurmctldLogFile={at}/controller.log\n\
             SlurmdLogFile={at}/node.log\nProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nReturnToService=2\n\
             SchedulerParameters=sched_interval=1\nMpiDefault=none\nSwitchType=switch/none\n\
             AccountingStorageType=accounting_storage/none\nJobAcctGatherType=jobacct_gather/none\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
             PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
        );
        let configuration = base.join("slurm.conf");
        std::fs::write(&configuration, text).expect("our own directory");
        let configuration = configuration.to_string_lossy().into_owned();
        let mut slurm = Self { daemons: Vec::new(), configuration };
        let own = |name: &str| format!("--{name}={at}/munge.{name}");
        let key = format!("--key-file={at}/key");
        let files = ["socket", "pid-file", "log-file", "seed-file"].map(own);
        let munge = [&["--foreground".to_owned(), "--force".to_owned(), key], &files[..]].concat();
        slurm.daemon("munged", &munge);
        if !wait_for(|| base.join("munge.socket").exists()) {
            return Err("munge does not start".into());
        }
        let of = |word: &str| vec![word.to_owned(), "-f".to_owned(), slurm.configuration.clone()];
        let (controller, node) = (of("-D"), [of("-D"), vec!["-N".into(), host.into()]].concat());
        slurm.daemon("slurmctld", &controller);
        slurm.daemon("slurmd", &node);
        let idle = || slurm.command("sinfo", &["-h", "-o", "%t"]).contains("idle");
        if !wait_for(idle) {
            let log = slurm.log(corner);
            let last = log.lines().last().unwrap_or("");
            return Err(Missing(format!("its node does not start: {last}")));
        }
        Ok(slurm)
    }

    fn daemon(&mut self, name: &str, arguments: &[String]) {
        let path = "/usr/local/sbin:/usr/sbin:/sbin:".to_owned();
        let path = path + &std::env::var("PATH").unwrap_or_default();
        let mut command = Command::new("env");
        command.arg(format!("PATH={path}")).arg(name).args(arguments);
        command.env("SLURM_CONF", &self.configuration);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        self.daemons.push(command.spawn().expect("it was looked for"));
    }

    /// Output of a client.
    pub fn command(&self, name: &str, arguments: &[&str]) -> String {
        let mut command = Command::new(name);
        let output = command.args(arguments).env("SLURM_CONF", &self.configuration).output();
        text(&output.expect("it was looked for"))
    }

    pub fn log(&self, corner: &Corner) -> String {
        let read = |name| std::fs::read_to_string(corner.path().join("slurm").join(name));
        ["controller.log", "node.log"].map(|name| read(name).unwrap_or_default()).concat()
    }
}

/// A private Slurm starts here.
pub fn slurm() -> Needed {
    for name in ["munged", "slurmctld", "slurmd"] {
        let found = ["/usr/sbin", "/usr/local/sbin", "/usr/bin"]
            .iter()
            .any(|directory| std::path::Path::new(directory).join(name).is_file());
        if !found {
            return Err(Missing(format!(
                "no {name} (Debian: munge, slurmctld, slurmd, slurm-client)"
            )));
        }
    }
    if !rustix::process::geteuid().is_root() {
        return Err("slurmd asks for root".into());
    }
    cases::program("sbatch")?;
    // Installed is not enough: a container may forbid the daemons' needs.
    Slurm::start(&Corner::new(PROGRAM)).map(|_| ())
}
