# shellcheck shell=dash
# Functions that scenarios share. Sourced by /scenario in the guest.

PLANT=/sys/kernel/debug/zplant
SCREEN=/sys/kernel/debug/zproj
SPOOL=/var/spool/contourd

fail() {
  echo "$*"
  exit 1
}

# wait_for SECONDS WHAT COMMAND...: runs the command every 50 ms of the guest's time until it succeeds.
wait_for() {
  left=$(($1 * 20))
  what=$2
  shift 2
  until "$@"; do
    left=$((left - 1))
    [ $left -gt 0 ] || fail "timed out waiting for $what"
    sleep 0.05
  done
}

# Makes folders for the spool and the socket and starts the daemon: start_daemon OPTION...
start_daemon() {
  mkdir -p $SPOOL /run/contourd
  contourd --config /etc/contourd/contourd.json "$@" 2>>/out/daemon.log &
  DAEMON=$!
  wait_for 60 "the daemon to be ready" test -S /run/contourd/control.sock
}

stop_daemon() {
  kill -TERM "$DAEMON"
  wait "$DAEMON"
}

print_model() {
  cp /model.stl $SPOOL/incoming/.part
  mv $SPOOL/incoming/.part $SPOOL/incoming/part.stl
}

# Polls rarely: a print takes minutes, and frequent polls cost the emulator more than the print.
wait_for_print() {
  left=900
  until print_is_over; do
    left=$((left - 1))
    [ $left -gt 0 ] || fail "timed out waiting for the end of the print"
    sleep 1
  done
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

# Loads the printer's devices: load_devices [PARAMETER OF ZPLANT...]; ZPROJ has the parameters of zproj. The plate is 2.5 mm
# above the switch.
load_devices() {
  insmod /mod/zplant.ko start_pos=2000 "$@"
  # shellcheck disable=SC2086  # none, or some
  insmod /mod/zproj.ko $ZPROJ
  insmod /mod/zserial.ko
}

light_is_on() { grep -q '^light 1$' $PLANT/state; }
light_is_off() { grep -q '^light 0$' $PLANT/state; }
lit_pictures() { awk '$3 == "FLIP" && $6 > 0 { n++ } END { print n + 0 }' $SCREEN/log; }

still_printing() { ! print_is_over || fail "the print ended too early"; }

# True during the exposure of layer N, counted from 1: its mask is on the screen and the light is on.
exposing() { still_printing && [ "$(lit_pictures)" -ge "$1" ] && light_is_on; }
# True after the exposure of layer N.
exposed() { still_printing && [ "$(lit_pictures)" -ge "$1" ] && [ "$(awk '{ lit = $6 } END { print lit }' $SCREEN/log)" = 0 ]; }
state_is() { contourctl status --json | grep -q "\"state\": *\"$1\""; }
uptime_s() { cut -d' ' -f1 /proc/uptime; }
