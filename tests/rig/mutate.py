#!/usr/bin/env python3
"""Reintroduces fixed defects, one at a time, and checks that print-rig finds each: a rig that finds nothing proves
nothing. Works in FOLDER, on a copy of the committed sources.

    tests/rig/mutate.py FOLDER [--prints N] [--only PART_OF_A_NAME]
"""

import argparse
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "planted"))

from planting import build, copy_head, planted  # noqa: E402

EXCHANGE = "hw/serial/command_exchange.cpp"
LIGHT = "hw/serial/projector_light.cpp"
LIGHT_STATES = "hw/serial/projector_light_states.cpp"
POWER_STATES = "hw/serial/projector_power_states.cpp"
READER = "hw/serial/reply_reader.cpp"
PROCESS = "daemon/print/layered_print.cpp"
STATES = "daemon/print/layered_states.cpp"
LINE = "hw/projector_with_light_line.cpp"
ENGINE = "hw/gpio/step_engine.cpp"
RISE = "daemon/print/continuous_print.cpp"
RISE_STATES = "daemon/print/continuous_states.cpp"

# Name, file, then pairs of a text that occurs exactly once and its replacement.
MUTATIONS = [
    ("after a lost reply light on is sent again", LIGHT, "                 .retries = 0});",
     "                 .retries = table_.retries});"),
    ("light is counted from the reply to light on", "hw/projector.hpp",
     "off_latest.value_or(now) - on_earliest", "off_latest.value_or(now) - on_latest.value_or(on_earliest)"),
    ("the exposure begins when light on is answered", "daemon/print/machine_process.hpp",
     "      light_end_ = earliest + time;",
     "      light_end_ = earliest + time + std::chrono::milliseconds{500};"),
    ("the print does not wait for darkness", PROCESS,
     "  machine_.projector().when_dark([this] { is_dark(); });",
     "  wait_ = clock_.call_after(Duration{0}, [this] { is_dark(); });"),
    ("a late or doubled reply to light on counts as darkness", EXCHANGE,
     "(if_ambiguous != Ambiguous::Counts && heard.reply->ambiguous)", "false"),
    ("any reply counts as darkness", EXCHANGE, "  const bool own = current_ && heard.reply->request == current_->id;",
     "  const bool own = current_.has_value();"),
    ("light off is sent once", LIGHT_STATES,
     "S::Overdue, F::RetryLater, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed",
     "S::Overdue, F::DropLightOn, F::ReportOverdue, F::TellUnconfirmed"),
    ("the light is taken for off after a failed light on", LIGHT_STATES,
     "{S::TurningOn, E::LightOnFailed, S::TurningOff, F::SendLightOff, F::TellUnlit}",
     "{S::TurningOn, E::LightOnFailed, S::Dark, F::TellUnlit}"),
    ("power off is sent once", POWER_STATES, "{S::TurningOff, E::PowerOffUnanswered, kStay, F::PowerOffAgain, F::AskWhetherOff}",
     "{S::TurningOff, E::PowerOffUnanswered, S::Unknown}"),
    ("a projector that says off while it warms up is believed", LIGHT,
     "  if (may_be_on() && clock_.now() < wiring_.warm_at()) return Event::SaysTooEarly;\n", ""),
    ("a late reply does not extend the time of those after it", READER,
     "  const auto kept = std::ranges::find_if(owed_, [now](const Owed& owed) { return owed.until >= now; });\n"
     "  owed_.erase(owed_.begin(), kept);",
     "  std::erase_if(owed_, [now](const Owed& owed) { return owed.until < now; });"),
    ("an interruption or a cancel leaves the light on", STATES,
     "{kLit, E::Interrupted, S::Interrupting, F::LightOff, F::BlackNow, F::AwaitDark}",
     "{kLit, E::Interrupted, S::Interrupting, F::BlackNow, F::AwaitDark}",
     "{kLit, E::Canceled, S::Interrupting, F::LightOff, F::BlackNow, F::AwaitDark}",
     "{kLit, E::Canceled, S::Interrupting, F::BlackNow, F::AwaitDark}"),
    ("an interrupted part is not counted", PROCESS,
     "  record_.exposure_least += light_->least();",
     "  if (!light_->off_latest) return;\n  record_.exposure_least = light_->least();"),
    ("a resumed layer's rest is computed from its least exposure", PROCESS,
     "  record_.exposure_most += light_->most(clock_.now());",
     "  record_.exposure_most += light_->least();"),
    ("an unconfirmed end of light counts as confirmed", PROCESS,
     "record_.dark_confirmed = record_.dark_confirmed && light_->off_latest;",
     "record_.dark_confirmed = record_.dark_confirmed || light_->off_latest;"),
    ("a projector found in place of a lost one answers for its light", PROCESS,
     "  if (known && known->on_earliest == light_->on_earliest) light_ = known;", "  light_ = known;"),
    ("a light behind a line counts as dark when the projector is dark", "hw/projector_with_light_line.hpp",
     "projector_.when_dark([this, call = std::move(call)] { line_projector_.when_dark(call); });",
     "projector_.when_dark(std::move(call));"),
    ("only one reply is expected to a repeated command", READER, "if (owed->repeated || reply.ambiguous)\n",
     "if (reply.ambiguous)\n"),
    ("an interrupted end forgets its light", PROCESS, "if (light_asked_ && !light_) {", "if (light_asked_) {"),
    ("a split exposure keeps its first picture", STATES, "{S::Exposing, E::PictureDue, kStay, F::ShowPicture}",
     "{S::Exposing, E::PictureDue, kStay}"),
    ("the rest of a split exposure begins with its first picture", "daemon/print/split_exposure.cpp",
     "  const std::size_t first = picture_at(times.past);", "  const std::size_t first = 0;"),
    ("a late picture is not recorded", PROCESS, "std::max(record_.late_picture, lit - *plan_->split->next_due());",
     "record_.late_picture;"),
    ("a light line that refuses is not asked again", LINE,
     "    if (!line_.refusal().empty()) return look_whether_dark(kLookAgain);\n", ""),
    ("a stop follows the clock, however late the steps are", ENGINE,
     "  if (late > harmless_ && come_to_rest(late)) return start_again(now, late);\n"
     "  if (stop_ && !stopped_) return slow_down(now, late);",
     "  if (stop_ && !stopped_) return slow_down(now, Duration{0});"),
    ("a motor that stood still continues at full rate", ENGINE,
     "  if (late > harmless_ && come_to_rest(late)) return start_again(now, late);\n", ""),
    ("a stall leaves the position known", ENGINE, "  if (speed > move_.pull_in) {", "  if (speed > 1e9) {"),
    ("the encoder is corrected without limit", "hw/gpio/axis_encoder.cpp", "plausibility_.refusal(off)",
     "plausibility_.refusal(0)"),
    ("the light of a rise counts from its command to the command for its end", RISE,
     "  const Duration most = since_then(span.on_earliest, span.off_latest);", "  const Duration most = now - from;",
     "  if (span.on_latest) record_.exposure_least += since_then(*span.on_latest, span.off_earliest);",
     "  record_.exposure_least += most;"),
    ("a lift of one stage after a rise has a second one", RISE,
     "    if (target == current_height() || (!looks && plan_->motion.second_lift == Nanometers{}))\n",
     "    if (target == current_height())\n"),
    ("a mask of a rise may be of any age", "daemon/print/rise_frames.cpp",
     "  if (apart(*plate, screen_.due) > kFarthest || apart(*section, screen_.cut) > kFarthestCut) {", "  if (false) {"),
    ("an interruption or a cancel of a rise leaves the light on", RISE_STATES,
     "{kMoving, {E::Interrupted, E::Canceled}, S::Braking, F::LightOff, F::BlackNow, F::StopAxis}",
     "{kMoving, {E::Interrupted, E::Canceled}, S::Braking, F::BlackNow, F::StopAxis}"),
    ("a plate that stops in a rise is lifted in the light", RISE_STATES,
     "{S::Rising, {E::MoveEnded, E::RiseBroken}, S::Darkening, F::LightOff, F::BlackNow, F::AwaitDark}",
     "{S::Rising, {E::MoveEnded, E::RiseBroken}, S::Lifting, F::LightOff, F::BlackNow, F::Lift}"),
    ("every edge restarts a safety input's debounce", "hw/gpio/contact.cpp",
     "  if (state_ == SafetyState::Safe) return first_;", "  if (state_ == SafetyState::Safe) return last_ + debounce_;",
     "  if (state_ == SafetyState::Safe) return step_to(",
     "  if (state_ == SafetyState::Safe && now - last_ < debounce_) return std::nullopt;\n"
     "  if (state_ == SafetyState::Safe) return step_to("),
]


def broken_rules(source, prints):
    build(source, source / "build", "print-rig")
    rig = subprocess.run([source / "build/bin/print-rig", "--prints", str(prints), "--show", "0"],
                         capture_output=True, text=True)
    rules = [line for line in rig.stdout.splitlines() if line.startswith("BROKEN")]
    return rules or ([f"print-rig exited with {rig.returncode}"] if rig.returncode not in (0, 1) else [])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--prints", type=int, default=2000)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    source = copy_head(options.folder)
    if rules := broken_rules(source, options.prints):
        sys.exit("\n".join(["without any defect:", *rules]))
    missed = 0
    for name, file, *changes in MUTATIONS:
        if options.only not in name:
            continue
        with planted(name, source / file, changes):
            rules = broken_rules(source, options.prints)
        print(f"{'found ' if rules else 'MISSED'}  {name}", *(f"\n        {rule}" for rule in rules), flush=True)
        missed += not rules
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
