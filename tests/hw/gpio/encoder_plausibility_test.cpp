#include "hw/gpio/encoder_plausibility.hpp"

#include "tests/catch.hpp"

using namespace contourd;

namespace {

// 800 counts a mm; 0.05 mm are 40 counts, and 20 illegal edges may be as many.
EncoderConfig config() {
  EncoderConfig config;
  config.a.line = "7";
  config.b.line = "8";
  config.counts_per_mm = 800;
  config.index = GpioLineConfig{};
  config.index_every = Nanometers{4'000'000};
  return config;
}

bool says(const std::optional<std::string>& sentence, const std::string& words) {
  UNSCOPED_INFO(sentence.value_or("nothing"));
  return sentence && sentence->find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("Illegal edges are too many in one move when the count may be off by more than the tolerance") {
  EncoderPlausibility encoder(config());
  encoder.move_begins(5);
  CHECK_FALSE(encoder.wrong_edges(25));
  CHECK(
      says(encoder.wrong_edges(26), "(line 7 of gpiochip0, line 8 of gpiochip0) made 21 edges in one move"));
  encoder.move_begins(26);
  CHECK_FALSE(encoder.wrong_edges(46));
}

TEST_CASE("A coarse encoder may have an illegal edge in a move, and no two") {
  EncoderConfig coarse = config();
  coarse.counts_per_mm = 20;
  EncoderPlausibility encoder(coarse);
  CHECK_FALSE(encoder.wrong_edges(1));
  CHECK(encoder.wrong_edges(2));
}

TEST_CASE("Steps that were lost at once are made good, up to a limit a move and one since homing") {
  EncoderPlausibility encoder(config());
  for (const double off : {-0.1, -0.2, 0.15}) {
    encoder.move_begins(0);
    CHECK_FALSE(encoder.refusal(off));
  }
  CHECK(encoder.corrected_mm() == testing::Approx(0.45));
  encoder.move_begins(0);
  CHECK(says(encoder.refusal(-0.06), "0.510 mm to be made good since homing, and 0.500 mm are allowed"));
  encoder.homed();
  encoder.move_begins(0);
  CHECK_FALSE(encoder.refusal(-0.2));
  CHECK(says(encoder.refusal(-0.06), "0.260 mm to be made good in one move, and 0.250 mm are allowed"));
}

TEST_CASE("A difference that came by and by is the encoder's and not made good") {
  EncoderPlausibility encoder(config());
  encoder.agreed(-0.02);
  encoder.agreed(-0.04);
  CHECK(says(encoder.refusal(-0.06), "that came by and by"));
  encoder.homed();
  encoder.agreed(-0.04);
  CHECK_FALSE(encoder.refusal(-0.09));  // more than half of it in this move
  encoder.agreed(0);
  CHECK_FALSE(encoder.refusal(-0.09));
}

TEST_CASE("An index pulse comes at the same count but for whole turns, or the count is off") {
  EncoderPlausibility encoder(config());
  CHECK_FALSE(encoder.index_error(1'000));  // the first: where it is
  CHECK_FALSE(encoder.index_error(1'000 + 3'200));
  CHECK_FALSE(encoder.index_error(1'000 - 2 * 3'200 + 40));
  CHECK(encoder.index_error(1'000 + 3'200 - 41) == -41);
  CHECK_FALSE(encoder.index_error(1'000 + 6'400 - 41));  // known by now
  CHECK_FALSE(encoder.index_refusal(-41));
  CHECK(encoder.corrected_mm() == testing::Approx(0.05125));
  encoder.homed();
  CHECK_FALSE(encoder.index_error(77));
}
