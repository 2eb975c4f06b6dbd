"""How each command of the pages is run: here in a scene, by another test, or not at all, and why. tests/pages/test_scenes.py checks that no
command is missing, and that none is here which no page has.

Each scene begins with the files of `inputs.py`: run.lcm, session.lcm, pictures, videos, vision.yaml and so on.
"""
from scenes import Given, Run, Scene

RUNNING = r"\[info\] \w+ is running"
IMAGES = "grown:home/.local/state/multireach/runs/*/images.lcm"  # launch.sh records images
PAGE = "http://127.0.0.1"
REPORTED = r"[\s\S]*images [1-9]\d*, targets [1-9]\d*, set-points"
HOAP2 = "--urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand"


def launched(text, **options):
    """launch.sh, ended by Ctrl-C after some seconds: its report has images and commands, and its exit code is that of an interrupted run."""
    return Run(text, **{"code": 130, "ready": IMAGES, "after_s": 1, "says": REPORTED, **options})


def node(text, **options):
    return Run(text, **{"ready": RUNNING, **options})


def ended(text, by=None):
    return Run(by or text, ends=text)


SCENES = (
    Scene("first run", (
        Run("tools/launch.sh --isolated --record run.lcm --json report.json", says="vision against truth"),
        Run("tools/multireach log info run.lcm", says="STEREO_IMAGES"),
        Run("tools/multireach log latency run.lcm"),
        Run("tools/multireach log export csv run.lcm -o tables"),
        Run("tools/multireach replay verify run.lcm"),
        Run("tools/multireach replay run logs/reach.lcm -o out.lcm"),
        Run("tools/multireach log report out.lcm --robot robots/hoap2", says="settle"),
        Run("tools/multireach log report run.lcm --robot robots/hoap2", says="settle"),
        Run("tools/multireach replay sweep logs/reach.lcm --set controller.gamma_rad2_m2=60,180,600 -o table.csv"),
        Run("tools/multireach log merge ~/.local/state/multireach/runs/DATE_TIME.PID/*.lcm -o run.lcm"),
    ), alone=True),
    Scene("launch", (
        launched("tools/launch.sh &"),
        Run("tools/multireach view --picture seen.jpg --seconds 5"),
        Run("tools/multireach robot pause", says="paused"),
        ended("tools/launch.sh &"),
        launched("tools/launch.sh --session other.lcm --vision its/vision.yaml"),
        ended("tools/launch.sh --session other.lcm --vision its/vision.yaml"),
        launched("tools/launch.sh --isolated"),
        ended("tools/launch.sh --isolated"),
        launched("tools/launch.sh --group 7"),
        ended("tools/launch.sh --group 7"),
        launched("tools/launch.sh --robot robots/ur5e --driver ur --emulator"),
    )),
    Scene("page", (
        launched("tools/launch.sh --view", says=PAGE + REPORTED),
        ended("tools/launch.sh --view"),
        launched("tools/launch.sh --isolated --view", says=PAGE + REPORTED),
        ended("tools/launch.sh --isolated --view"),
        launched("tools/launch.sh --practice", ready=PAGE, after_s=4, says="the files of the set-up are in "),
        ended("tools/launch.sh --practice"),
        Run("tools/multireach page --robot robots/hoap2 --vision robots/hoap2/vision.yaml", ready=PAGE),
        Run("tools/multireach page --log run.lcm", ready=PAGE),
        Run("tools/multireach page --log old.lcm --compare new.lcm", ready=PAGE),
    ), needs=("page",)),
    Scene("keys", (
        Run("tools/multireach key new ~/.multireach-key"),
        launched("tools/launch.sh --key ~/.multireach-key"),
        Run("tools/multireach robot --key ~/.multireach-key pause", says="paused"),
        Run("export MULTIREACH_KEY=~/.multireach-key"),
        Given("tools/multireach robot status"),
        ended("tools/launch.sh --key ~/.multireach-key"),
        launched("tools/multireach key new my.key && tools/launch.sh --key my.key"),
    )),
    Scene("target", (
        node("tools/multireach robot-sim --config robots/hoap2"),
        node("tools/multireach bridge --config robots/hoap2"),
        node("tools/multireach controller --config robots/hoap2"),
        Run("tools/multireach publish target 0.1 -0.12 0.1", ready="sending 'target'", after_s=1),
        Run("tools/multireach robot status", says="^running"),
        Run("tools/multireach robot speed 10", says="speed 10 %"),
        Run("tools/multireach robot enable"),
    )),
    Scene("arm", (
        Run("cp -r robots/ur5e robots/NAME"),
        Run("rm robots/NAME/ur5e.urdf robots/NAME/README.md"),
        Run("cp FILE.urdf robots/NAME/"),
        Given("sed -i 's/ur5e.urdf/FILE.urdf/' robots/NAME/robot.yaml"),
        launched("tools/launch.sh --robot robots/NAME --isolated"),
        ended("tools/launch.sh --robot robots/NAME --isolated"),
        launched("tools/launch.sh --robot robots/NAME --driver DRIVER --emulator", stands_for={"DRIVER": "ur"}),
        ended("tools/launch.sh --robot robots/NAME --driver DRIVER --emulator"),
        node("multireach-robot-emulator --config robots/NAME &"),
        node("multireach-robot-driver --config robots/NAME --simulated &", ready="the robot: ready"),
        node("multireach-bridge --config robots/NAME &"),
        node("multireach-controller --config robots/NAME &"),
        Run("multireach-publish target 0.4 0.1 0.3", ready="sending 'target'", after_s=1),
        Run("multireach-robot speed 10", says="speed 10 %"),
        Run("multireach-robot enable"),
    )),
    Scene("cameras", (
        Run("multireach-camera device --config cameras.yaml"),
        launched('tools/launch.sh --camera "device --config cameras.yaml" --vision vision.yaml'),
        ended('tools/launch.sh --camera "device --config cameras.yaml" --vision vision.yaml'),
        node("multireach-camera device --config cameras.yaml &"),
        node("multireach-vision --config vision.yaml &"),
        Given("rm -f run.lcm"),
        Run("lcm-logger run.lcm", ready="Opening log file", after_s=1),
        ended("lcm-logger run.lcm"),
        node("multireach-vision --config vision.yaml"),
    )),
    Scene("recording a session", (
        Given("rm logs/reach.lcm"),
        Run("lcm-logger --lcm-url='udpm://239.255.76.68:7668?ttl=0' logs/reach.lcm &", ready="Opening log file"),
        Run("multireach-camera render --config logs/reach.yaml"),
        ended("lcm-logger --lcm-url='udpm://239.255.76.68:7668?ttl=0' logs/reach.lcm &", by="kill -INT %1"),
        Given("[ $(multireach-log info logs/reach.lcm | awk '$1 == \"STEREO_IMAGES\" { print $3 }') -gt 700 ]"),
    )),
    Scene("playing", (
        Run("lcm-logplayer --lcm-url='udpm://239.255.76.67:7667?ttl=0' run.lcm"),
    )),
    Scene("logs", (
        Run("multireach-log info run.lcm"),
        Run("multireach-log check run.lcm", code=1),  # load.lcm was recorded with faults
        Run("multireach-log cut run.lcm -o part.lcm --from 4 --until 5"),
        Run("multireach-log filter run.lcm -o joints.lcm --channel 'JOINT_*' ROBOT_STATE"),
        Run("multireach-log merge part.lcm joints.lcm -o merged.lcm"),
        Run("multireach-log export csv run.lcm -o tables"),
        Run("multireach-log export mcap run.lcm -o run.mcap"),
        Run("tools/multireach log export mcap run.lcm -o run.mcap"),
        Run("multireach-log images part.lcm -o images"),
        Run("multireach-log check logs/damaged.lcm", code=1),
    )),
    Scene("import", (
        Run("multireach-log import MH_01_easy -o session.lcm", says=r"^\d+ pairs"),
        Run("multireach-log import pictures -o session.lcm", says=r"^\d+ pairs"),
        Run("multireach-log import left.mp4 right.mp4 -o session.lcm", says=r"^\d+ pairs"),
        Run("multireach-log import run.mcap -o session.lcm --left /left/image_raw --right /right/image_raw", says=r"^\d+ pairs"),
        Run("tools/multireach log import run.mcap -o session.lcm --left /left/image_raw --right /right/image_raw", says=r"^\d+ pairs"),
        Run("multireach-replay run session.lcm --vision vision.yaml -o out.lcm"),
        Run("multireach-log report out.lcm --robot robots/hoap2", says="seen"),
        Run("multireach-log export pairs session.lcm -o pictures"),
        Run("multireach-log export euroc session.lcm -o recording"),
        Run("multireach-log export bag session.lcm -o session.bag"),
    )),
    Scene("replay", (
        Run("multireach-replay run logs/reach.lcm -o out.lcm"),
        Run("multireach-replay verify live.lcm"),
        Run("multireach-replay verify logs/load.lcm"),
        Run("multireach-replay bisect old.lcm new.lcm"),
        Run("multireach-replay sweep logs/reach.lcm --set controller.gamma_rad2_m2=100,350 -o table.csv"),
        Run("tools/multireach replay sweep logs/reach.lcm --set controller.gamma_rad2_m2=100,180,350 -o table.csv"),
        Run("multireach-replay sweep session.lcm --set controller.gamma_rad2_m2=100,350 --set tracker.max_process_noise_m2_s3=5,10 -o table.csv"),
    )),
    Scene("sweep in parts", (
        Run("parallel multireach-replay sweep session.lcm --set controller.gamma_rad2_m2=$(seq -s, 50 10 800) --jobs 1 --shard {}/8 --json "
            "shard{}.json ::: $(seq 0 7)"),
        Run("multireach-replay sweep merge shard*.json -o table.csv"),
        Run("multireach-replay sweep session.lcm --set controller.gamma_rad2_m2=$(seq -s, 50 10 800) --jobs 8 --shard "
            "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT --json shard$SLURM_ARRAY_TASK_ID.json",
            environment={"SLURM_ARRAY_TASK_ID": "7", "SLURM_ARRAY_TASK_COUNT": "8"}),  # Slurm's
    ), needs=("parallel",)),
    Scene("vision", (
        Run("tools/multireach vision --config robots/hoap2/vision.yaml --pair left.png right.png"),
        Run("multireach-vision --config vision.yaml --pair left.png right.png"),
        Run("multireach-calibrate colour --left left.png --click-left 195,111 --right right.png --click-right 148,112 -o ball.yaml --picture check.png"),
        Run("multireach-calibrate convert stereo.yml --size 640x480 --unit mm -o stereo.yaml"),
        Run("multireach-calibrate convert intrinsics.yml extrinsics.yml --size 640x480 --unit mm -o camchain.yaml"),
        Run("multireach-calibrate convert camchain.yaml -o left.yaml -o right.yaml"),
    )),
    Scene("studies", (
        Run(f"tools/multireach trace {HOAP2} --law guarded --start=0.2,-0.3,-0.2,-0.9 --target=0.1,-0.12,0.1 --gamma 350 --steps 300"),
        Run(f"tools/multireach study {HOAP2} --samples 20000 --csv -"),
        Run(f"multireach-study {HOAP2} --law guarded --gamma 100,350 --samples 20000 --json study.json"),
        Run(f"multireach-study straightness {HOAP2} --samples 1000 --seed 90 --json straight.json"),
        Run(f"build/release/bin/multireach-figures fig13 {HOAP2} -o curves.csv --measures -"),
        Run(f"build/release/bin/multireach-figures protocol-reaches {HOAP2} -o curves.csv --measures -"),
        Given(f"for k in 0 1; do multireach-study {HOAP2} --samples 100 --shard $k/2 --json shard$k.json; done"),
        Run("multireach-study status", says="2 done"),
        Run("multireach-study merge shard*.json --json study.json"),
    )),
    Scene("figures", (
        Run("studies/figures.sh fig13"),
        Run("studies/figures.sh protocol-reaches-hoap2"),
    ), needs=("gnuplot",)),
    Scene("Python", (
        Run("export PYTHONPATH=$PWD/build/release/python"),
        Run("/usr/bin/python3 examples/python/reach.py --robot robots/hoap2 --target 0.1 -0.12 0.1", says=r"error 0\.0"),
    ), needs=("python/multireach",)),
)

# The test script that runs a command; where another file is between the two, that too.
DEBIAN = ("tests/full/debian_package.sh",)
ELSEWHERE = {
    "tools/setup.sh tests": ("tools/test.sh",),
    "tools/docs.sh": ("tools/test.sh",),
    "ctest --preset release --label-regex unit --parallel 2": ("tools/test.sh",),
    "tools/package.sh": DEBIAN,
    "tools/setup.sh package": (*DEBIAN, "tools/package.sh"),
    "apt install --no-install-recommends ./multireach_*.deb": (*DEBIAN, "Containerfile"),
    "apt install --no-install-recommends ./build/packages/multireach_*.deb": (*DEBIAN, "Containerfile"),
    "apt install ./build/packages/python3-multireach_*.deb": DEBIAN,
    "multireach-launch --isolated": DEBIAN,
    "cmake --install build/release": ("tests/package/run.sh",),
    "g++ mine.cpp $(pkg-config --cflags --libs multireach) -std=c++20": ("tests/package/run.sh",),
    "g++ mine.cpp $(pkg-config --cflags --libs multireach-vision) -std=c++20": ("tests/package/run.sh",),
    "tools/launch.sh --record run.lcm --json report.json": ("tests/live/whole_loop.sh",),
    "tools/launch.sh --record run.lcm": ("tests/live/whole_loop.sh",),
    "tools/launch.sh --role eyes": ("tests/live/two_hosts.sh",),
    "tools/launch.sh --role robot": ("tests/live/two_hosts.sh",),
    "tools/doctor.sh": ("tests/live/doctor.sh",),
    "ssh robot multireach key share .multireach-key | multireach key new ~/.multireach-key --shared": ("tests/live/keys.sh",),
    "multireach-log import run.bag -o session.lcm --left /left/image_raw --right /right/image_raw": ("tests/live/import.sh",),
    "multireach-replay play logs/reach.lcm --lockstep": ("tests/live/lockstep.sh",),
    "multireach-study tracking --urdf robots/panda/panda.urdf --base panda_link0 --tip panda_hand --samples 20 --seed 7": ("tests/live/study.sh",),
    "multireach-study throws --urdf robots/panda/panda.urdf --base panda_link0 --tip panda_hand --samples 1000 --seed 9": ("tests/live/study.sh",),
    f"build/release/bin/multireach-study {HOAP2} --law paper --gamma 100,350,1000 --samples 2000000 --json study.json --failures failures.csv":
        ("tests/live/study.sh",),
    "multireach-calibrate cameras --left 'left*.png' --right 'right*.png' --pattern 9x6 --square 0.025 -o stereo.yaml --picture residuals.png "
    "--json calibration.json --leave-one-out": ("tests/live/calibrate.sh",),
    "multireach-calibrate colour --left left.png --click-left 225,245 --right right.png --rectangle-right 160,221,66,58 -o ball.colour.yaml "
    "--picture check.png": ("tests/live/calibrate.sh",),
    "multireach-calibrate colour --left near.png --click-left 225,245 --left far.png --click-left 310,190 --without-left empty.png "
    "-o ball.colour.yaml": ("tests/live/calibrate.sh",),
    "multireach-calibrate hand-eye --log run.lcm --robot robot.yaml --vision vision.yaml -o pose.yaml": ("tests/live/calibrate.sh",),
    "parallel --retries 3 multireach-study --urdf arm.urdf --base base --tip hand --samples 100000000 --threads 1 --shard {}/64 --json "
    "shard{}.json ::: $(seq 0 63)": ("tests/full/many_machines.sh",),
    "multireach-study --urdf arm.urdf --base base --tip hand --samples 10000000000 --threads 8 --shard "
    "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT --json shard$SLURM_ARRAY_TASK_ID.json": ("tests/full/many_machines.sh",),
    "[ $? -lt 128 ] || scontrol requeue $SLURM_JOB_ID": ("tests/full/many_machines.sh",),
}

# Why no test runs a command.
NO_CAMERAS = "the cameras are devices of the reader's; with video files in their place, docs/cameras.md's other commands are run"
NO_SYSTEMD = "needs a computer that systemd has started; tests/live/systemd_units.sh checks the units, and runs what they start"
NOT_RUN = {
    "tools/test.sh": "runs all tests, these among them",
    "tools/test.sh --full": "runs all tests, these among them",
    "tools/spy.sh": "opens a window, and ends when a person closes it",
    "tools/launch.sh --camera \"device --left 0 --right 2\" --vision vision.yaml": NO_CAMERAS,
    "tools/launch.sh --camera \"device --left 0 --right 2\" --vision vision.yaml --view": NO_CAMERAS,
    "tools/launch.sh --view --course my_setup --camera \"device --left 0 --right 2\"": NO_CAMERAS,
    "tools/launch.sh --role eyes --camera \"device --left 0 --right 2\" --vision vision.yaml": NO_CAMERAS,
    "multireach-camera device --left 0 --right 2": NO_CAMERAS,
    "multireach-calibrate colour --left left.png --right right.png --in-window -o ball.colour.yaml": "a person clicks in its window",
    "tools/launch.sh --robot robots/NAME --driver ur --camera \"device --left 0 --right 2\" --vision vision.yaml": "needs a real robot and cameras",
    "multireach-robot-driver --config robots/NAME &": "needs a real robot; with an emulator the same command has --simulated",
    "podman run --rm --cap-add NET_ADMIN --cap-add SYS_ADMIN multireach multireach-launch --isolated":
        "needs a container engine and its images; tests/full/debian_package.sh runs the steps of the Containerfile",
    "tools/setup.sh python": "would build again what is being tested; tools/test.sh runs it with the part tests",
    "systemctl enable multireach.target multireach@{camera,vision,controller} multireach-record@{control,images}": NO_SYSTEMD,
    "systemctl enable multireach.target multireach@{bridge,robot-sim} multireach-record@{control,images}": NO_SYSTEMD,
    "systemctl start multireach.target": NO_SYSTEMD,
    "systemctl status 'multireach*'": NO_SYSTEMD,
    "journalctl -fu multireach@bridge": NO_SYSTEMD,
}
