#include "hw/gpio/encoder_plausibility.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/encoder_config.hpp"

namespace {

// The tolerance of 0.05 mm is 40 counts, the error that 20 illegal edges may cause.
const EncoderConfig kEncoder = testing::encoder_config(800);

}  // namespace

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
