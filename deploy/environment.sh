# Sourced by run and test: makes the environment in .venv of this checkout, or finds it as it should be.
# prepare_environment run|test

say() { printf 'deploy: %s\n' "$*" >&2; }
fail() { printf 'deploy: %s\n' "$*" >&2; exit 2; }

# Aravis comes as a GObject typelib; PyGObject from pip would need headers and a compiler.
DEBIAN_PACKAGES=(python3-venv python3-gi gir1.2-aravis-0.8)
# The tests start servers of their own, in folders of their own, run the calls that README and handbook show, and open the
# page in a browser.
DEBIAN_PACKAGES_OF_TESTS=(postgresql nginx curl chromium)

lock_of() { if [ "$1" = test ]; then echo deploy/test.lock; else echo requirements.lock; fi; }

fingerprint() { cat pyproject.toml deploy/environment.sh "$(lock_of "$1")" | sha256sum | cut -d' ' -f1; }

is_prepared() { [ -x .venv/bin/station ] && [ "$(cat ".venv/prepared-$1" 2>/dev/null)" = "$(fingerprint "$1")" ]; }

missing_debian_packages() {
    local name needed=("${DEBIAN_PACKAGES[@]}")
    [ "$1" = run ] || needed+=("${DEBIAN_PACKAGES_OF_TESTS[@]}")
    for name in "${needed[@]}"; do
        [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || echo "$name"
    done
}

# Debian's postgresql would make and start a server for the whole machine, its nginx take port 80.
forbid_servers_of_machine() {
    if [ ! -e /etc/postgresql-common ]; then
        "$@" mkdir -p /etc/postgresql-common/createcluster.d
        echo 'create_main_cluster = false' | "$@" tee /etc/postgresql-common/createcluster.d/treadline.conf >/dev/null
    fi
    if [ ! -e /etc/nginx ] && [ ! -e /etc/systemd/system/nginx.service ]; then
        "$@" mkdir -p /etc/systemd/system
        "$@" ln -s /dev/null /etc/systemd/system/nginx.service
        say "nginx is not started on this machine; whoever wants it types: systemctl unmask nginx"
    fi
}

install_debian_packages() {
    local missing log as_root=()
    missing=$(missing_debian_packages "$1" | xargs)
    [ -n "$missing" ] || return 0
    command -v apt-get >/dev/null || fail "apt-get is not here; allowed: Debian 12; install by hand: $missing"
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || fail "missing Debian packages: $missing; run as root once: apt-get install $missing"
        as_root=(sudo)
    fi
    [ "$1" = run ] || forbid_servers_of_machine "${as_root[@]}"
    say "installing Debian packages: $missing"
    log=$(mktemp)
    # shellcheck disable=SC2086  # a list of names
    { "${as_root[@]}" apt-get update && "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install --yes --no-install-recommends $missing; } >"$log" 2>&1 || true
    # apt-get update answers 0 even where no mirror is reached: ask what is installed instead.
    missing=$(missing_debian_packages "$1" | xargs)
    [ -z "$missing" ] || fail "apt could not install $missing ($(grep -E '^(E|Err|W):?' "$log" | tail -n 1)); check the network and /etc/apt/sources.list, log in $log"
    rm -f "$log"
}

install_python_packages() {
    local lock log
    lock=$(lock_of "$1")
    log=$(mktemp)
    if [ ! -x .venv/bin/python ]; then
        say "making .venv with $(/usr/bin/python3 --version)"
        /usr/bin/python3 -m venv --system-site-packages .venv >"$log" 2>&1 || fail "cannot make .venv ($(tail -n 1 "$log"))"
    fi
    say "installing the Python packages of $lock"
    { .venv/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement "$lock" \
        && .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .; } \
        >"$log" 2>&1 || fail "pip could not install $lock ($(grep '^ERROR' "$log" | tail -n 1)); check the network or set PIP_INDEX_URL to a mirror, log in $log"
    rm -f "$log"
}

prepare_environment() {
    is_prepared "$1" && return 0
    # What the tests need is more than what running needs.
    [ "$1" = run ] && is_prepared test && return 0
    install_debian_packages "$1"
    install_python_packages "$1"
    fingerprint "$1" >".venv/prepared-$1"
}
