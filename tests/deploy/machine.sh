#!/bin/bash
# A machine to try a package on: the files of this one under a layer that is thrown away, and Debian's systemd as its first
# process, which does one thing and ends.
# machine.sh LAYER LIFE COMMAND...: COMMAND runs there as root, with the folder LIFE as /life; what it writes is in LIFE/out.
set -eu
layer=$1 life=$2
shift 2
mount --make-rprivate /
mount -t tmpfs tmpfs "$layer"
mkdir "$layer"/{upper,work,root,groups}
root=$layer/root

# A control group of its own: systemd rules over the one that it is started in, and all below.
mount -t cgroup2 cgroup2 "$layer/groups"
group=$layer/groups/machine-$$
mkdir "$group"
echo $$ >"$group/cgroup.procs"

mount -t overlay overlay -o lowerdir=/,upperdir="$layer/upper",workdir="$layer/work" "$root"
mount --rbind /sys "$root/sys"
mount --make-rprivate "$root/sys"
mount -t tmpfs -o mode=755 tmpfs "$root/dev"
for device in null zero full random urandom tty; do
    touch "$root/dev/$device"
    mount --bind "/dev/$device" "$root/dev/$device"
done
mkdir "$root"/dev/{pts,shm}
mount -t devpts -o newinstance,ptmxmode=0666,mode=620 devpts "$root/dev/pts"
ln -s pts/ptmx "$root/dev/ptmx"
ln -s /proc/self/fd "$root/dev/fd"
for folder in tmp run dev/shm; do mount -t tmpfs -o mode=1777 tmpfs "$root/$folder"; done
chmod 755 "$root/run"
mkdir "$root/life" "$root/before"
mount --bind "$life" "$root/life"

# Nothing of what this machine starts.
rm -rf "$root"/etc/systemd/system/*.wants
: >"$root/etc/fstab"
echo 0123456789abcdef0123456789abcdef >"$root/etc/machine-id"
mkdir -p "$root/run/systemd/system"
cat >"$root/run/systemd/system/life.service" <<UNIT
[Unit]
SuccessAction=exit-force
FailureAction=exit-force
[Service]
Type=oneshot
ExecStart=$*
StandardOutput=file:/life/out
StandardError=inherit
UNIT

# Where it may be seen: another process id, network, host name and control group than this machine's.
# shellcheck disable=SC2016  # for the inner shell
inner='
set -eu
cd "$1"
mount -t proc proc proc
mount --bind proc/sys proc/sys
mount -o remount,bind,ro proc/sys
umount -R sys
mount -t sysfs -o ro sysfs sys
mount -t cgroup2 cgroup2 sys/fs/cgroup
pivot_root . before
umount -l /before
# As on a machine; in one that is private nobody would see the credentials that systemd mounts for a service.
mount --make-rshared /
exec env -i container=machine PATH=/usr/sbin:/usr/bin:/sbin:/bin /lib/systemd/systemd --unit=life.service </dev/null
'
status=0
setpriv --pdeathsig KILL unshare --mount --pid --net --uts --ipc --cgroup --fork --kill-child=KILL bash -c "$inner" inner "$root" || status=$?
echo $$ >"$layer/groups/cgroup.procs"
find "$group" -depth -type d -exec rmdir {} \;
exit "$status"
