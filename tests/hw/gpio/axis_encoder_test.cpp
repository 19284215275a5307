#include "hw/gpio/axis_encoder.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/encoder_config.hpp"

namespace {

using Policy = EncoderConfig::Policy;

// Returns an axis with 800 steps and 400 counts a mm: its tolerance of 0.05 mm is 40 steps, or 20 counts.
GpioAxisConfig fine_encoder_axis(Policy policy = Policy::Fault) {
  GpioAxisConfig config;
  config.encoder = testing::encoder_config(400);
  config.encoder->policy = policy;
  return config;
}

AxisEncoder encoder_of(const GpioAxisConfig& axis) {
  return {axis, axis.encoder.value()};
}

EncoderReading counted(std::int64_t count) {
  return {.count = count};
}
EncoderReading passed_index(std::uint64_t pulses, std::int64_t count) {
  return {.count = count, .index_pulses = pulses, .index_count = count};
}

bool is_well(const AxisEncoder::Finding& finding) {
  return !finding.fault && !finding.notice;
}

// The tolerance of 0.05 mm is 40 counts, the error that 20 illegal edges may cause.
const EncoderConfig kEncoder = testing::encoder_config(800);

}  // namespace

TEST_CASE("The measured position is the agreed one plus the counts since then") {
  AxisEncoder encoder = encoder_of(fine_encoder_axis());
  encoder.agree(counted(1'000), -80);
  CHECK(encoder.plate(counted(1'000)) == -80);
  CHECK(encoder.plate(counted(1'400)) == 720);  // 1 mm
  CHECK(encoder.plate(counted(600)) == -880);
}

TEST_CASE("A reversed encoder's count falls as the plate rises") {
  GpioAxisConfig reversed = fine_encoder_axis();
  reversed.encoder->reversed = true;
  AxisEncoder encoder = encoder_of(reversed);
  encoder.agree(counted(-50), 0);
  CHECK(encoder.plate(counted(-450)) == 800);
  CHECK(encoder.plate(counted(350)) == -800);
}

TEST_CASE("At rest, a difference up to the tolerance is ignored") {
  AxisEncoder encoder = encoder_of(fine_encoder_axis());
  encoder.agree(counted(0), 0);
  CHECK(is_well(encoder.compare(counted(20), 0)));
  CHECK(is_well(encoder.compare(counted(-20), 0)));
  CHECK_FALSE(is_well(encoder.compare(counted(21), 0)));
  CHECK_FALSE(is_well(encoder.compare(counted(-21), 0)));
}

TEST_CASE("At rest, a difference beyond the tolerance is a fault with its figures, or is corrected") {
  const std::string words = "the encoder measures 0.900 mm but the motor's steps make 1.000 mm";
  AxisEncoder strict = encoder_of(fine_encoder_axis());
  strict.agree(counted(0), 0);
  CHECK(says(strict.compare(counted(360), 800).fault, words));

  AxisEncoder lenient = encoder_of(fine_encoder_axis(Policy::Correct));
  lenient.agree(counted(0), 0);
  lenient.move_begins(counted(0));
  const AxisEncoder::Finding finding = lenient.compare(counted(360), 800);
  CHECK_FALSE(finding.fault);
  CHECK(says(finding.notice, words));
  CHECK(says(finding.notice, "corrected by further steps, 0.100 mm in all since homing"));
}

TEST_CASE("A correction beyond the limit per move or since homing is a fault, and homing resets the sums") {
  AxisEncoder encoder = encoder_of(fine_encoder_axis(Policy::Correct));
  encoder.agree(counted(0), 0);
  encoder.move_begins(counted(0));
  CHECK(says(encoder.compare(counted(-101), 0).fault, "0.250 mm are allowed"));
  encoder.agree(counted(0), 0);
  for (int move = 0; move < 2; ++move) {
    encoder.move_begins(counted(0));
    CHECK_FALSE(encoder.compare(counted(-99), 0).fault);
  }
  encoder.move_begins(counted(0));
  CHECK(says(encoder.compare(counted(-99), 0).fault, "0.500 mm are allowed"));
  encoder.agree(counted(0), 0);
  encoder.move_begins(counted(0));
  CHECK_FALSE(encoder.compare(counted(-99), 0).fault);
}

TEST_CASE("A difference that grew over several moves is a fault with either policy") {
  AxisEncoder encoder = encoder_of(fine_encoder_axis(Policy::Correct));
  encoder.agree(counted(0), 0);
  encoder.move_begins(counted(0));
  CHECK(is_well(encoder.compare(counted(-18), 0)));
  encoder.move_begins(counted(0));
  CHECK(says(encoder.compare(counted(-30), 0).fault, "grew over several moves"));
}

TEST_CASE("While the motor turns, the encoder may lag by the tolerance plus 5 ms at top speed") {
  // 0.05 mm, and 10 mm/s for 5 ms: 0.1 mm, 40 counts.
  AxisEncoder encoder = encoder_of(fine_encoder_axis());
  encoder.agree(counted(0), 0);
  CHECK_FALSE(encoder.runaway(counted(40), 0, true));
  CHECK(says(encoder.runaway(counted(41), 0, true), "steps were lost"));
  CHECK(says(encoder.runaway(counted(-41), 0, true), "steps were lost"));
}

TEST_CASE("While the motor turns, a correctable difference is no runaway, unless the position is unknown") {
  // 0.25 mm and 0.05 mm: 120 counts.
  AxisEncoder encoder = encoder_of(fine_encoder_axis(Policy::Correct));
  encoder.agree(counted(0), 0);
  CHECK_FALSE(encoder.runaway(counted(-120), 0, true));
  CHECK(encoder.runaway(counted(-121), 0, true));
  CHECK(encoder.runaway(counted(-41), 0, false));
}

TEST_CASE(
    "While the position is unknown, the screw's play is no runaway and distances count from the start") {
  // 0.05 mm, 0.05 mm and 0.1 mm of play: 80 counts.
  GpioAxisConfig c = fine_encoder_axis();
  c.backlash = Nanometers{100'000};
  AxisEncoder encoder = encoder_of(c);
  encoder.agree(counted(0), 8'000);
  CHECK_FALSE(encoder.runaway(counted(80), 8'000, false));
  CHECK(says(encoder.runaway(counted(0), 7'200, false),
             "the encoder measures 0.000 mm but the motor's steps make -1.000 mm"));
  CHECK(encoder.runaway(counted(41), 8'000, true));
}

TEST_CASE("An encoder with more illegal edges in a move than the tolerance allows is a fault") {
  AxisEncoder encoder = encoder_of(fine_encoder_axis());
  encoder.move_begins({.illegal_edges = 3});
  CHECK(is_well(encoder.check({.illegal_edges = 13}, false)));
  CHECK(says(encoder.check({.illegal_edges = 14}, false).fault, "made 11 impossible edges in one move"));
  encoder.move_begins({.illegal_edges = 14});
  CHECK(is_well(encoder.check({.illegal_edges = 24}, true)));
}

TEST_CASE("An index that disagrees is a fault, or corrects the count and reports it") {
  // The index is passed every 1,600 counts; the count is off by 100, 0.25 mm.
  AxisEncoder strict = encoder_of(fine_encoder_axis());
  strict.agree(counted(0), 0);
  CHECK(is_well(strict.check(passed_index(1, 200), true)));
  CHECK(is_well(strict.check(passed_index(2, 1'800), true)));
  CHECK(says(strict.check(passed_index(3, 300), true).fault,
             "the encoder's index (line 9 of gpiochip0) shows that its count is off by 0.250 mm"));

  for (const bool reversed : {false, true}) {
    CAPTURE(reversed);
    GpioAxisConfig c = fine_encoder_axis(Policy::Correct);
    c.encoder->reversed = reversed;
    AxisEncoder lenient = encoder_of(c);
    lenient.agree(counted(0), 0);
    lenient.move_begins(counted(0));
    CHECK(is_well(lenient.check(passed_index(1, 200), true)));
    CHECK(says(lenient.check(passed_index(2, 300), true).notice, "the count is corrected"));
    CHECK(lenient.plate(counted(300)) == (reversed ? -400 : 400));
    // A pulse is checked only once.
    CHECK(is_well(lenient.check(passed_index(2, 300), true)));
  }
}

TEST_CASE("Index pulses from before the position is known are ignored") {
  AxisEncoder encoder = encoder_of(fine_encoder_axis());
  CHECK(is_well(encoder.check(passed_index(1, 200), false)));
  CHECK(is_well(encoder.check(passed_index(2, 500), false)));
  encoder.agree(passed_index(2, 500), 0);
  CHECK(is_well(encoder.check(passed_index(2, 500), true)));
  CHECK(is_well(encoder.check(passed_index(3, 900), true)));  // the first pulse that counts
}

TEST_CASE("Illegal edges are too many in one move when the count may be off by more than the tolerance") {
  EncoderPlausibility encoder(kEncoder);
  encoder.move_begins(5);
  CHECK_FALSE(encoder.wrong_edges(25));
  CHECK(says(encoder.wrong_edges(26),
             "(line 7 of gpiochip0, line 8 of gpiochip0) made 21 impossible edges in one move"));
  encoder.move_begins(26);
  CHECK_FALSE(encoder.wrong_edges(46));
}

TEST_CASE("A coarse encoder may have one illegal edge in a move but not two") {
  EncoderConfig coarse = kEncoder;
  coarse.counts_per_mm = 20;
  EncoderPlausibility encoder(coarse);
  CHECK_FALSE(encoder.wrong_edges(1));
  CHECK(encoder.wrong_edges(2));
}

TEST_CASE("Steps lost in one move are corrected, up to a limit per move and one since homing") {
  EncoderPlausibility encoder(kEncoder);
  for (const double off : {-0.1, -0.2, 0.15}) {
    encoder.move_begins(0);
    CHECK_FALSE(encoder.refusal(off));
  }
  CHECK(encoder.corrected_mm() == testing::Approx(0.45));
  encoder.move_begins(0);
  CHECK(says(encoder.refusal(-0.06), "a correction of 0.510 mm since homing, and 0.500 mm are allowed"));
  encoder.homed();
  encoder.move_begins(0);
  CHECK_FALSE(encoder.refusal(-0.2));
  CHECK(says(encoder.refusal(-0.06), "a correction of 0.260 mm in one move, and 0.250 mm are allowed"));
}

TEST_CASE("A difference that grew over several moves is blamed on the encoder and not corrected") {
  EncoderPlausibility encoder(kEncoder);
  encoder.agreed(-0.02);
  encoder.agreed(-0.04);
  CHECK(says(encoder.refusal(-0.06), "grew over several moves"));
  encoder.homed();
  encoder.agreed(-0.04);
  CHECK_FALSE(encoder.refusal(-0.09));  // more than half of it in this move
  encoder.agreed(0);
  CHECK_FALSE(encoder.refusal(-0.09));
}

TEST_CASE("An index pulse at a count that is not a whole number of turns from the first shows an error") {
  EncoderPlausibility encoder(kEncoder);
  CHECK_FALSE(encoder.index_error(1'000));  // the first sets the reference
  CHECK_FALSE(encoder.index_error(1'000 + 3'200));
  CHECK_FALSE(encoder.index_error(1'000 - 2 * 3'200 + 40));
  CHECK(encoder.index_error(1'000 + 3'200 - 41) == -41);
  CHECK_FALSE(encoder.index_error(1'000 + 6'400 - 41));  // after the error was found
  CHECK_FALSE(encoder.index_refusal(-41));
  CHECK(encoder.corrected_mm() == testing::Approx(0.05125));
  encoder.homed();
  CHECK_FALSE(encoder.index_error(77));
}
