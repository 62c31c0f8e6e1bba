//! A Slurm of its own on this machine: a controller and two nodes, gone with the test.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs::{self, File};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::drivers::skipped;
use crate::programs::{Outcome, finish};

/// Within which a cluster starts.
const PATIENCE: Duration = Duration::from_secs(60);

/// Starts the daemons with the folder `$0`, and ends with standard input.
const DAEMONS: &str = "
    PATH=$PATH:/usr/sbin:/sbin
    mungekey --create --keyfile=\"$0/key\"
    munged --foreground --key-file=\"$0/key\" --socket=\"$0/munge\" --pid-file=\"$0/munge.pid\" \
        --log-file=\"$0/munge.log\" --seed-file=\"$0/seed\" &
    until [ -S \"$0/munge\" ]; do sleep 0.05; done
    slurmctld -D & slurmd -D -N node1 & slurmd -D -N node2 &
    read -r";

/// A cluster of two nodes, `node1` and `node2`, which both are this machine; the second has the feature `second`.
/// Numbers of array tasks stay below 6.
#[derive(Debug)]
pub struct Cluster {
    folder: TempDir,
    daemons: Child,
}

impl Cluster {
    /// Starts a cluster, of which everything lies in a temporary folder: key, sockets, state and logs. `None`, and a
    /// word about it, where `tests/run` has seen no Slurm that can be started.
    ///
    /// # Panics
    /// If it does not start.
    pub fn start() -> Option<Self> {
        if std::env::var_os("RAYSCOPE_SLURM").is_none() {
            skipped(
                "studies on a cluster",
                "RAYSCOPE_SLURM is not set, which says that Slurm can be started",
            );
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir(root.join("state")).unwrap();
        fs::write(root.join("slurm.conf"), configuration(root)).unwrap();
        // The system ends all processes of a namespace, tasks included, with the first one, and that with this thread,
        // however it ends.
        let mut command = Command::new("setpriv");
        command.args("--pdeathsig KILL unshare --pid --mount-proc --kill-child --fork bash -c".split(' '));
        command.arg(DAEMONS).arg(root).env("SLURM_CONF", root.join("slurm.conf")).stdin(Stdio::piped());
        let log = File::create(root.join("log")).unwrap();
        let daemons = command.stdout(log.try_clone().unwrap()).stderr(log).spawn();
        let cluster = Self { daemons: daemons.expect("setpriv starts"), folder };
        let begun = Instant::now();
        while cluster.finish("sinfo --noheader --Node --format=%T").stdout != "idle\nidle\n" {
            if begun.elapsed() > PATIENCE {
                panic!(
                    "Slurm does not start:\n{}",
                    fs::read_to_string(cluster.folder.path().join("log")).unwrap()
                );
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Some(cluster)
    }

    /// Has a program, and what it starts, talk to this cluster.
    pub fn serve<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf"))
    }

    /// What one of Slurm's programs says.
    ///
    /// # Panics
    /// If it fails.
    pub fn run(&self, line: &str) -> String {
        self.finish(line).succeeded().stdout
    }

    fn finish(&self, line: &str) -> Outcome {
        let mut words = line.split_whitespace();
        finish(self.serve(Command::new(words.next().unwrap()).args(words)))
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        // It closes their standard input first.
        self.daemons.wait().unwrap();
    }
}

/// `slurm.conf` with everything in `root`, and nothing that is heard outside this machine.
fn configuration(root: &Path) -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
    let host = host.trim().split('.').next().unwrap();
    let root = root.display();
    // Free ones, all three held until all are known.
    let ports: [TcpListener; 3] = [(); 3].map(|()| TcpListener::bind("127.0.0.1:0").unwrap());
    let [controller, first, second] = ports.each_ref().map(|port| port.local_addr().unwrap().port());
    format!(
        "ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={root}/munge
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
StateSaveLocation={root}/state
SlurmdSpoolDir={root}/%n
SlurmctldPidFile={root}/slurmctld.pid
SlurmdPidFile={root}/%n.pid
SlurmdParameters=config_overrides
SchedulerParameters=sched_min_interval=0,batch_sched_delay=0
MailProg=/bin/true
MpiDefault=none
ReturnToService=1
MaxArraySize=6
NodeName=node1 NodeHostname={host} NodeAddr=127.0.0.1 Port={first} CPUs=2
NodeName=node2 NodeHostname={host} NodeAddr=127.0.0.1 Port={second} CPUs=2 Feature=second
PartitionName=all Nodes=ALL Default=YES
"
    )
}
