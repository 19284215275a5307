# What scenarios share. Sourced by /scenario, in the guest.

PLANT=/sys/kernel/debug/zplant
SCREEN=/sys/kernel/debug/zproj
SPOOL=/var/spool/contourd

fail() {
  echo "$*"
  exit 1
}

# wait_for SECONDS WHAT COMMAND...: asks every 50 ms of the guest's time.
wait_for() {
  left=$(($1 * 20))
  what=$2
  shift 2
  until "$@"; do
    left=$((left - 1))
    [ $left -gt 0 ] || fail "waited in vain for $what"
    sleep 0.05
  done
}

# A folder for the spool and the socket, and the daemon in it: start_daemon OPTION...
start_daemon() {
  mkdir -p $SPOOL /run/contourd
  contourd --config /etc/contourd/contourd.json "$@" 2>>/out/daemon.log &
  DAEMON=$!
  wait_for 60 "the daemon to be ready" test -S /run/contourd/control.sock
}

stop_daemon() {
  kill -TERM $DAEMON
  wait $DAEMON
}

print_model() {
  cp /model.stl $SPOOL/incoming/.part
  mv $SPOOL/incoming/.part $SPOOL/incoming/part.stl
}

print_is_over() {
  [ -e $SPOOL/done/part.stl ] || [ -e $SPOOL/failed/part.stl ]
}

keep_logs() {
  [ ! -e $PLANT ] || cp $PLANT/log /out/edges
  [ ! -e $PLANT ] || cp $PLANT/state /out/plant
  [ ! -e $SCREEN ] || cp $SCREEN/log /out/frames
  mkdir -p /out/spool
  cp -r $SPOOL/done $SPOOL/failed $SPOOL/incoming $SPOOL/printing /out/spool/
}
