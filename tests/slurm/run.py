#!/usr/bin/python3
"""A farm under Slurm on this machine: two node daemons, a killed and requeued task, one with a time limit that it cannot keep, and
the bits of one process.

usage: run.py LACQUER [-v]

Starts munged, slurmctld and two slurmd of its own in a temporary folder, on ports of the loopback interface, as
the user who runs it. Skips with a reason where Debian's packages slurmctld, slurmd, slurm-client and munge are
not installed.
Exit status: 0 passed or skipped; 1 failed.
"""
import getpass
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

PROGRAMS = ["slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "munged"]
SCENE = """Film "rgb" "integer xresolution" 200 "integer yresolution" 150 "string filename" "scene.exr"
Sampler "zsobol" "integer pixelsamples" 64
LookAt 0 1 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [.4 .5 .6]
Material "conductor" "float roughness" 0.2
Shape "sphere"
Material "diffuse"
Translate 0 -1 0 Rotate 90 1 0 0
Shape "disk" "float radius" 5
"""
TASKS = 4
LONG = 1024  # samples per pixel that take a minute or more
os.environ["PATH"] += ":/usr/sbin:/sbin"


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Cluster:
    """Daemons that end with it."""

    def __init__(self, folder):
        self.folder, self.processes = folder, []
        self.environment = dict(os.environ, SLURM_CONF=os.path.join(folder, "slurm.conf"))

    def path(self, name):
        return os.path.join(self.folder, name)

    def start(self, name, *command):
        log = open(self.path(name + ".out"), "w")
        self.processes.append(subprocess.Popen(command, env=self.environment, stdout=log, stderr=log, cwd=self.folder))

    def run(self, *command):
        result = subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=300, cwd=self.folder)
        if result.returncode != 0:
            raise RuntimeError("%s: %s" % (" ".join(command), result.stderr))
        return result.stdout

    def configure(self):
        control, first, second = free_ports(3)
        user, host = getpass.getuser(), socket.gethostname().split(".")[0]
        for name in ("state", "spool-n1", "spool-n2"):
            os.mkdir(self.path(name))
        with open(self.path("slurm.conf"), "w") as f:
            f.write("""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=requeue_setup_env_fail
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
SlurmdParameters=config_overrides
KillWait=5
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={first} CPUs=1
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={second} CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
""".format(host=host, control=control, first=first, second=second, user=user, folder=self.folder))

    def munge(self):
        with open(self.path("munge.key"), "wb") as f:
            f.write(os.urandom(128))
        os.chmod(self.path("munge.key"), 0o600)
        self.start("munged", "munged", "--foreground", "--force", "--key-file=" + self.path("munge.key"),
                   "--socket=" + self.path("munge.socket"), "--pid-file=" + self.path("munge.pid"),
                   "--log-file=" + self.path("munge.log"), "--seed-file=" + self.path("munge.seed"))

    def __enter__(self):
        self.configure()
        self.munge()
        wait("munged", 20, lambda: os.path.exists(self.path("munge.socket")))
        self.start("slurmctld", "slurmctld", "-D", "-c")
        for node in ("n1", "n2"):
            self.start("slurmd-" + node, "slurmd", "-D", "-N", node)
        wait("the nodes", 90, lambda: self.idle() == 2)
        return self

    def idle(self):
        try:
            return self.run("sinfo", "-h", "-N", "-o", "%T").split().count("idle")
        except RuntimeError:
            return 0

    def __exit__(self, *_):
        for process in reversed(self.processes):
            process.send_signal(signal.SIGTERM)
        for process in self.processes:
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()

    def logs(self):
        for name in sorted(os.listdir(self.folder)):
            if name.endswith((".log", ".out", ".pid")) and os.path.isfile(self.path(name)):
                with open(self.path(name), errors="replace") as f:
                    print("--- %s\n%s" % (name, f.read()[-3000:]))


def wait(what, seconds, condition):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.1)
    raise RuntimeError("%s: not within %d s" % (what, seconds))


def digest(image):
    text = subprocess.run(["oiiotool", "--info", "-v", "--hash", image], capture_output=True, text=True).stdout
    return re.search(r"SHA-1: (\w+)", text).group(1)


def submit(cluster, lacquer, name, jobs, *options):
    """Splits a render and hands it to Slurm: its folder, its image, and the numbers of its tasks and of its merge."""
    folder, image = cluster.path(name), cluster.path(name + ".exr")
    cluster.run(lacquer, "farm", "split", cluster.path("scene.pbrt"), "--jobs", str(jobs), "--outfile", image, "--folder", folder,
                "--slurm=--mem=0", *options)
    said = cluster.run("sh", os.path.join(folder, "submit.sh"))
    return (folder, image) + re.search(r"job (\d+); image: job (\d+)", said).groups()


def restarts(cluster, task):
    return int(re.search(r"Restarts=(\d+)", cluster.run("scontrol", "show", "job", task)).group(1))


def wait_for_end(cluster, merge):
    wait("the end of the job", 60, lambda: merge not in cluster.run("squeue", "-h", "-o", "%i").split())


def requeued(cluster, lacquer):
    """Split, run, kill and requeue one task, merge."""
    whole = cluster.path("whole.exr")
    cluster.run(lacquer, cluster.path("scene.pbrt"), "--outfile", whole, "--quiet")
    folder, image, tasks, merge = submit(cluster, lacquer, "farm", TASKS, "--checkpoint-every", "0.1", "--render-options",
                                         "--nthreads 1")
    state = os.path.join(folder, "part-1.state")
    wait("a state of the first task", 60, lambda: os.path.exists(state))
    cluster.run("scontrol", "requeue", tasks + "_1")
    wait("the image", 300, lambda: os.path.exists(image))
    assert restarts(cluster, tasks + "_1") == 1
    assert digest(image) == digest(whole), "the bits differ"
    wait_for_end(cluster, merge)
    print("a task requeued, %d tasks and a merge: the bits of one process" % TASKS)


def limited(cluster, lacquer):
    """A task that takes longer than its time limit: it stops by itself, waits for another turn, and goes on. Slurm counts minutes, and
    lets what was requeued wait for two."""
    folder, image, tasks, merge = submit(cluster, lacquer, "limited", 1, "--slurm=--time=2", "--spp", str(LONG),
                                         "--render-options", "--nthreads 1")
    task = tasks + "_1"
    wait("the first turn's end", 150, lambda: restarts(cluster, task) > 0)
    info = cluster.run(lacquer, "info", os.path.join(folder, "part-1.state"))
    wait("the image", 1200, lambda: os.path.exists(image))
    turns = restarts(cluster, task) + 1
    wait_for_end(cluster, merge)
    whole = cluster.path("long.exr")
    cluster.run(lacquer, cluster.path("scene.pbrt"), "--spp", str(LONG), "--outfile", whole, "--quiet")
    assert digest(image) == digest(whole), "the bits differ"
    print("a time limit of two minutes, %d turns: the bits of one process; after the first:\n%s" % (turns, info))


def main():
    missing = [p for p in PROGRAMS if not shutil.which(p)]
    if missing:
        print("SKIP: not installed: %s (Debian: slurmctld slurmd slurm-client munge)" % ", ".join(missing))
        print("0 passed, 0 failed, 1 skipped")
        return 0
    lacquer = os.path.abspath(sys.argv[1])
    folder = tempfile.mkdtemp(prefix="lacquer-slurm-")
    cluster = Cluster(folder)
    try:
        with open(cluster.path("scene.pbrt"), "w") as f:
            f.write(SCENE)
        with cluster:
            requeued(cluster, lacquer)
            limited(cluster, lacquer)
        print("2 passed, 0 failed")
        return 0
    except (RuntimeError, AssertionError) as e:
        print("FAIL:", e)
        cluster.logs()
        print("0 passed, 1 failed")
        return 1
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
