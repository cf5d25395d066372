#!/usr/bin/env bash
# Passes the tests on a fresh Debian or Ubuntu machine, with no GPU: installs a software Vulkan
# adapter where there is no adapter, and the Python readers that check the output files, then runs
# every test. Arguments go to `cargo test`.
set -euo pipefail
cd "$(dirname "$0")/.."

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
has_vulkan() {
    # No `grep -q`: it would close the pipe early, and pipefail would take that for a failure.
    ldconfig -p | grep libvulkan.so.1 >/dev/null || return 1
    compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}

if [ "$(uname)" = Linux ] && ! has_vulkan; then
    echo "tests/run.sh: installing a software Vulkan adapter" >&2
    as_root apt-get update -qq
    as_root apt-get install -y -qq mesa-vulkan-drivers libvulkan1 >&2
fi

venv="$(realpath -m "${DIFFUSPH_VENV:-target/python}")"
if ! "$venv/bin/python" -c 'import meshio, pyvista' 2>/dev/null; then
    echo "tests/run.sh: installing the Python readers into $venv" >&2
    if ! python3 -m venv "$venv" 2>/dev/null; then
        as_root apt-get update -qq
        as_root apt-get install -y -qq python3-venv >&2
        python3 -m venv "$venv"
    fi
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r tests/readers/requirements.txt
fi
export DIFFUSPH_PYTHON="$venv/bin/python"

# The Vulkan loader complains where this is not set; any folder will do.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"

cargo test "$@"
