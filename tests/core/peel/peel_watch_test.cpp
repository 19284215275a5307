#include "core/peel/peel_watch.hpp"

#include "tests/catch.hpp"

namespace {

constexpr double kLeastMm2 = 20;

Nanometers at_mm(double mm) {
  return Nanometers{std::llround(mm * 1e6)};
}

struct PeelWatchFixture {
  PeelFinding peels(double area_mm2) {
    watch.lift(at_mm(1), false);
    CHECK_FALSE(watch.change(true, at_mm(1.1)));
    CHECK(watch.change(false, at_mm(1.3)));
    return watch.judge(area_mm2);
  }
  PeelFinding is_silent(double area_mm2) {
    watch.lift(at_mm(1), false);
    return watch.judge(area_mm2);
  }

  PeelWatch watch{kLeastMm2};
};

}  // namespace

TEST_CASE_METHOD(PeelWatchFixture, "The peel of a layer ends when the force falls for the last time") {
  CHECK(peels(100) == PeelFinding::None);
  CHECK(watch.peel() == LayerPeel{true, at_mm(0.3)});
  CHECK_FALSE(watch.change(true, at_mm(1.5)));
  CHECK(watch.change(false, at_mm(1.7)));
  CHECK(watch.peel() == LayerPeel{true, at_mm(0.7)});
}

TEST_CASE_METHOD(PeelWatchFixture, "A force from before the lift is no peel, and the layer is not judged") {
  for (int i = 0; i < PeelWatch::kFeltBefore; ++i)
    CHECK(peels(100) == PeelFinding::None);
  watch.lift(at_mm(1), true);
  CHECK_FALSE(watch.change(false, at_mm(1.1)));
  CHECK(watch.peel() == LayerPeel{});
  CHECK(watch.judge(100) == PeelFinding::None);
  // The force that begins afterwards is.
  watch.lift(at_mm(1), true);
  CHECK_FALSE(watch.change(false, at_mm(1.1)));
  CHECK_FALSE(watch.change(true, at_mm(1.2)));
  CHECK(watch.change(false, at_mm(1.4)));
  CHECK(watch.peel() == LayerPeel{true, at_mm(0.4)});
}

TEST_CASE_METHOD(PeelWatchFixture, "A layer that is not felt after others that were has come off") {
  for (int i = 0; i < PeelWatch::kFeltBefore; ++i)
    CHECK(peels(100) == PeelFinding::None);
  CHECK(is_silent(kLeastMm2 - 1) == PeelFinding::None);  // too small to be felt
  CHECK(is_silent(99) == PeelFinding::None);             // smaller than any that was felt
  CHECK(is_silent(100) == PeelFinding::CameOff);
  // Whoever goes on is not told again of the next layer.
  CHECK(is_silent(100) == PeelFinding::None);
  for (int i = 0; i < PeelWatch::kFeltBefore; ++i)
    CHECK(peels(100) == PeelFinding::None);
  CHECK(is_silent(200) == PeelFinding::CameOff);
}

TEST_CASE_METHOD(PeelWatchFixture, "A signal that is silent from the start is found once") {
  for (int i = 1; i < PeelWatch::kSilentFromStart; ++i) {
    CHECK(is_silent(100) == PeelFinding::None);
    CHECK(is_silent(1) == PeelFinding::None);  // a small layer says nothing
  }
  CHECK(is_silent(100) == PeelFinding::NeverFelt);
  for (int i = 0; i < 100; ++i)
    CHECK(is_silent(100) == PeelFinding::None);
}
