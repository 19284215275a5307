# shellcheck shell=dash
# Runs jobs on a disk whose writes are recorded, and starts the daemon on that disk as a power cut leaves it. In the guest, as root:
#   sh power_cuts.sh work alone           only the daemon writes
#   sh power_cuts.sh work among-others    another program keeps synchronizing the file system
#   sh power_cuts.sh cut_power SEED       cuts the power, starts the daemon on the disk, and waits until it is idle
# Results are in /run/out.
# shellcheck source=tests/vm/guest/lib.sh
. /srv/lib.sh

DATA=/dev/disk/by-id/virtio-data
RECORD=/dev/disk/by-id/virtio-record
DISK=/disk
SPOOL=$DISK/spool
OUT=/run/out

# within SECONDS WHAT COMMAND...: repeats the command until it succeeds, for at most SECONDS by the clock.
within() {
  end=$(($(date +%s) + $1))
  what=$2
  shift 2
  until "$@"; do
    [ "$(date +%s)" -lt $end ] || fail "timed out waiting for $what"
    sleep 0.1
  done
}

# --- the daemon and its user

# Starts the daemon like the unit, with its state folder on the disk: start_daemon CONFIGURATION
start_daemon() {
  install -d -o contourd -g contourd /run/contourd
  setpriv --reuid contourd --regid contourd --clear-groups --inh-caps +lease --ambient-caps +lease \
    env STATE_DIRECTORY=$DISK/state contourd --config "/etc/contourd/$1.json" 2>>$OUT/daemon.log &
  DAEMON=$!
  (within 60 "the daemon to be ready" test -S /run/contourd/control.sock)
}

stop_daemon() {
  kill -TERM "$DAEMON"
  wait "$DAEMON"
}

# Writes the daemon's reports to watchers to a file until it stops. A watch ends with each print; the next one begins with the
# job that ended last.
start_watched_daemon() {
  start_daemon "$1"
  while kill -0 "$DAEMON" 2>/dev/null; do contourctl watch --json; done >>$OUT/told 2>/dev/null &
}

has_told() { grep -q "\"last\":{\"job\":\"$1\",\"outcome\":\"$2\"" $OUT/told; }
pauses() { contourctl pause >/dev/null 2>&1; }
occupies_plate() { contourctl status | grep -q "^plate *occupied by $1\$"; }

# --- the user who drops jobs

mark() { dmsetup message recorded 0 mark "$1"; }

# Drops a job as a member of the group, and synchronizes it to the disk before it is marked. Tickets come before their models.
drop() {
  umask "$2"
  cd /srv/jobs/"$1" || exit
  for file in *.json; do
    [ ! -e "$file" ] || put "$file"
  done
  for file in *; do
    case $file in *.json) ;; *) put "$file" ;; esac
  done
  sync $SPOOL/incoming
}

put() {
  cp -r "$1" "$SPOOL/incoming/.$1"
  # Permissions come from the umask alone.
  chmod -R =rwX "$SPOOL/incoming/.$1"
  find "$SPOOL/incoming/.$1" -exec sync {} +
  mv "$SPOOL/incoming/.$1" "$SPOOL/incoming/$1"
}

# give JOB [UMASK]
give() {
  setpriv --reuid 1001 --regid 1001 --groups "$(stat -c %g $SPOOL)" sh /srv/power_cuts.sh drop "$1" "${2:-002}"
  mark "in:$1"
}

# ended JOB OUTCOME [NAME]: waits for the job's end, under NAME if the daemon had to rename it.
ended() {
  within 120 "the end of $1" has_told "${3:-$1}" "$2"
  case $2 in done) mark "done:$1" ;; *) mark "failed:$1" ;; esac
}

prints() {
  give "$@"
  ended "$1" "done"
}

# Starts a job that pauses after its first light.
begins() {
  give "$1"
  within 60 "the print of $1" pauses
  within 60 "the first light of $1" occupies_plate "$1"
  mark "begun:$1"
}

clear_plate_of() {
  mark "occupied:$1"
  mark "clearing:$1"
  contourctl plate-cleared >/dev/null
  mark "cleared:$1"
}

# --- the jobs

one_by_one() {
  prints plain
  prints ticketed
  prints plate
  prints foreign 022
  give broken
  ended broken failed
  give broken-foreign 022
  ended broken-foreign failed
}

# Jobs that wait for a print are checked, and refused, while it is paused.
in_a_queue() {
  begins cancelled
  give twins
  give broken-waiting
  give broken-plate
  give queued
  ended broken-waiting failed
  ended broken-plate failed
  contourctl cancel >/dev/null
  ended cancelled cancelled
  within 120 "the twins" has_told twin "done"
  within 120 "the twins" has_told twin-2 "done"
  mark done:twins
  ended queued "done"
}

over_a_stop() {
  begins stopped
  stop_daemon
  mark failed:stopped
  start_watched_daemon printer
  give held
  mark resuming
  contourctl resume >/dev/null
  ended held "done"
}

one_plate_at_a_time() {
  stop_daemon
  start_watched_daemon careful-printer
  clear_plate_of held
  prints first
  give second
  clear_plate_of first
  ended second "done"
  clear_plate_of second
}

synchronize_again_and_again() {
  while :; do
    uptime_s >$DISK/other
    sync $DISK/other
    sleep 0.05
  done
}

make_disk() {
  mkdir -p $DISK $OUT
  dmsetup create recorded --table "0 $(blockdev --getsz $DATA) log-writes $DATA $RECORD"
  mke2fs -q -t ext4 -b 4096 -E nodiscard,lazy_itable_init=0,lazy_journal_init=0 /dev/mapper/recorded
  mount -t ext4 /dev/mapper/recorded $DISK
  install -d -o contourd -g contourd -m 2755 $SPOOL $SPOOL/printing
  install -d -o contourd -g contourd -m 2775 $SPOOL/incoming $SPOOL/done $SPOOL/failed
  install -d -o contourd -g contourd -m 0700 $DISK/state
}

work() {
  make_disk
  start_watched_daemon printer
  mark start
  if [ "$1" = among-others ]; then
    synchronize_again_and_again &
    OTHER=$!
  fi
  one_by_one
  in_a_queue
  over_a_stop
  one_plate_at_a_time
  stop_daemon
  if [ "$1" = among-others ]; then
    kill "$OTHER"
    wait "$OTHER"
  fi
  mark end
  umount $DISK
  dmsetup remove recorded
}

# --- after the cut

# True if no job is being processed and incoming/ contains only files that the status lists as deletable, and tickets without a model.
at_rest() {
  contourctl status >$OUT/status.now
  grep -q '^state *idle$' $OUT/status.now && [ -z "$(ls $SPOOL/printing)" ] || return
  for path in "$SPOOL"/incoming/*; do
    case $path in *.json | *'/*') continue ;; esac
    grep -q "^deletable ${path##*/} " $OUT/status.now || return
  done
}

keep_state() { tar -C $DISK -cf "$OUT/$1.tar" --exclude='*.png' --exclude='*.html' spool state; }

cut_power() {
  rm -rf $OUT
  mkdir -p $DISK $OUT
  replay-log $RECORD $DATA "$1" >$OUT/cut || fail "replay-log did not make the disk"
  mount -t ext4 $DATA $DISK || fail "the file system cannot be mounted"
  keep_state before
  # Simulates a restart of the computer by a new boot id.
  cat /proc/sys/kernel/random/uuid >/run/boot_id
  mount --bind /run/boot_id /proc/sys/kernel/random/boot_id
  start_daemon printer >$OUT/trouble
  contourctl status --json >$OUT/status
  ! grep -q '"held":"' $OUT/status || contourctl plate-cleared >/dev/null
  (within 60 "the queue to be empty" at_rest) >>$OUT/trouble || cat $OUT/status.now >>$OUT/trouble
  stop_daemon
  echo $? >$OUT/exit_code
  keep_state after
  (cd $DISK && find spool state -type f -size 0) >$OUT/empty
  umount $DISK /proc/sys/kernel/random/boot_id
  e2fsck -fn $DATA >$OUT/fsck 2>&1 || cat $OUT/fsck >>$OUT/trouble
}

"$@"
