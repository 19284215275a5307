#include "core/continuous/rise_planner.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "tests/catch.hpp"
#include "tests/core/continuous/rise_fixture.hpp"
#include "tests/core/engine_fixture.hpp"

namespace {

using contourd::testing::Approx;

constexpr double kForever = std::numeric_limits<double>::infinity();

const RiseBounds kBounds{
    .lit = {{Micrometers{150}, MillijoulesPerCm2{8}}, MilliwattsPerCm2{4}, Micrometers{30}},
    .margin = 4,
    .refill = {.viscosity_pa_s = 0.2, .pressure_kpa = 50},
    .fastest = MillimetersPerSecond{0.1},
    .slowest = MillimetersPerSecond{5.0 / 3600},
    .acceleration = MillimetersPerSecondSquared{5},
    .window = std::chrono::duration<double>(kForever)};

// Returns slabs of 0.1 mm with the distances of a function of the height in mm.
template <typename Distance>
std::vector<RiseSlab> slabs_up_to(double top_mm, const Distance& distance_mm) {
  std::vector<RiseSlab> slabs;
  for (std::int64_t i = 1; i <= std::llround(top_mm * 10); ++i)
    slabs.push_back({Nanometers{100'000} * i, Millimeters{distance_mm(static_cast<double>(i) / 10 - 0.05)}});
  return slabs;
}

// Returns the widest distance of the sections between two heights.
Millimeters distance_within(const std::vector<RiseSlab>& slabs, Nanometers low, Nanometers high) {
  Millimeters widest{};
  for (auto slab = std::ranges::lower_bound(slabs, low, {}, &RiseSlab::top); slab != slabs.end(); ++slab) {
    widest = std::max(widest, slab->distance);
    if (slab->top >= high) break;
  }
  return widest;
}

// Returns a complaint about the first height at which a plan breaks a law; empty if none does. The gap is
// that of the slowest speed of the way that gelling resin has come, and the sections are those from the gap's
// other side up to the plate.
std::string broken_law(const RisePlan& plan, const std::vector<RiseSlab>& slabs, const RiseBounds& bounds) {
  if (plan.points.size() < 3) return "no plan";
  (void)duration(plan);  // requires what a plan is
  const Nanometers way{std::llround(gel_gap(bounds.lit, bounds.margin).count() * 1000)}, step{997};
  const auto rest = plan.points.front().height;
  for (std::size_t i = 1; i < plan.points.size(); ++i) {
    const RisePoint &from = plan.points[i - 1], &to = plan.points[i];
    const double change = std::pow(to.speed.count(), 2) - std::pow(from.speed.count(), 2);
    if (std::fabs(change) / (2 * in_mm(to.height - from.height)) > bounds.acceleration.count() * 1.000001)
      return "acceleration";
  }
  for (Nanometers height = rest + step; height < plan.points.back().height; height += step) {
    const MillimetersPerSecond speed = speed_at(plan, height);
    MillimetersPerSecond slowest = speed;
    for (Nanometers before = height; before > height - way && before >= rest; before -= way / 20)
      slowest = std::min(slowest, speed_at(plan, before));
    if (height - way <= rest) slowest = MillimetersPerSecond{};
    const Micrometers gap = gel_gap(bounds.lit, margin_at(bounds.lit, slowest));
    const std::string at = " at " + std::to_string(in_mm(height)) + " mm";
    if (speed.count() >
        refill_speed(bounds.refill, gap, distance_within(slabs, std::max(height - way, rest + step), height))
                .count() *
            1.000001)
      return "refill" + at;
    if (speed.count() > cure_speed(bounds.lit, bounds.margin).count() * 1.000001) return "cure" + at;
    if (speed.count() > bounds.fastest.count() * 1.000001) return "machine" + at;
  }
  return {};
}

std::optional<RisePlan> only_plan(const std::vector<RiseSlab>& slabs, const RiseBounds& bounds = kBounds,
                                  Nanometers from = {}) {
  const std::vector<RisePlan> rises = plan_rises(slabs, from, bounds);
  if (rises.size() != 1) return std::nullopt;
  return rises.front();
}

// Returns the limit at a height.
RiseLimit limit_at(const RisePlan& plan, Nanometers height) {
  return std::prev(std::ranges::upper_bound(plan.points, height, {}, &RisePoint::height))->limit;
}

}  // namespace

TEST_CASE("A narrow column rises at the speed of its cure, from its start to its top") {
  const std::vector<RiseSlab> slabs = slabs_up_to(20, [](double) { return 5.0; });
  const std::optional<RisePlan> plan = only_plan(slabs);
  REQUIRE(plan);
  CHECK(broken_law(*plan, slabs, kBounds).empty());
  CHECK(plan->points.front().height == Nanometers{});
  CHECK(plan->points.back().height == mm(20));
  CHECK(mm_h(speed_at(*plan, mm(10))) == Approx(55.26).epsilon(1e-3));
  CHECK(limit_at(*plan, mm(10)) == RiseLimit::Cure);
  CHECK(duration(*plan).count() == Approx(20 / 55.26 * 3600).epsilon(1e-3));
}

TEST_CASE("The plate goes on above a rise by the gel gap of its last speed, and not beyond its travel") {
  const std::vector<RiseSlab> slabs =
      slabs_up_to(5, [](double height_mm) { return height_mm > 4 ? 26.0 : 4.0; });
  const auto gap_um = [](MillimetersPerSecond speed) {
    return gel_gap(kBounds.lit, margin_at(kBounds.lit, speed)).count();
  };
  const RisePlan slow_at_top = only_plan(slabs).value();
  const MillimetersPerSecond slowest = speed_at(slow_at_top, Nanometers{4'900'000});
  CHECK(mm_h(slowest) < 40);
  CHECK(in_mm(slow_at_top.overrun) * 1000 == Approx(gap_um(slowest)).margin(0.01));
  RiseBounds bounds = kBounds;
  const std::vector<RiseSlab> narrow = slabs_up_to(5, [](double) { return 4.0; });
  CHECK(in_mm(only_plan(narrow, bounds).value().overrun) * 1000 ==
        Approx(gel_gap(kBounds.lit, 4).count()).margin(0.01));
  bounds.travel = Nanometers{5'040'000};
  CHECK(only_plan(narrow, bounds).value().overrun == Nanometers{40'000});
  bounds.travel = mm(5);
  CHECK(only_plan(narrow, bounds).value().overrun == Nanometers{});
}

TEST_CASE("The plate stays slow above a wide section until its masks have passed") {
  const std::vector<RiseSlab> slabs =
      slabs_up_to(5, [](double height_mm) { return height_mm < 3 ? 26.0 : 4.0; });
  const RisePlan plan = only_plan(slabs).value();
  CHECK(broken_law(plan, slabs, kBounds).empty());
  CHECK(mm_h(speed_at(plan, Nanometers{3'090'000})) < 45);
  CHECK(mm_h(speed_at(plan, Nanometers{3'450'000})) > 55);
}

TEST_CASE("A rise slows down before a wide section and speeds up after it") {
  const std::vector<RiseSlab> slabs =
      slabs_up_to(20, [](double height_mm) { return height_mm > 9 && height_mm < 11 ? 28.0 : 4.0; });
  const std::optional<RisePlan> plan = only_plan(slabs);
  REQUIRE(plan);
  CHECK(broken_law(*plan, slabs, kBounds).empty());
  CHECK(mm_h(speed_at(*plan, Nanometers{8'900'000})) > 55);
  CHECK(mm_h(speed_at(*plan, mm(10))) == Approx(9.3).margin(0.1));
  CHECK(limit_at(*plan, mm(10)) == RiseLimit::Refill);
  CHECK(mm_h(speed_at(*plan, mm(12))) > 55);
}

TEST_CASE("A wide rise speeds up only as its gap widens") {
  const std::vector<RiseSlab> slabs = slabs_up_to(20, [](double) { return 22.0; });
  const std::optional<RisePlan> plan = only_plan(slabs);
  REQUIRE(plan);
  CHECK(broken_law(*plan, slabs, kBounds).empty());
  const double at_start = mm_h(speed_at(*plan, Nanometers{50'000}));
  CHECK(at_start == Approx(mm_h(refill_speed(kBounds.refill, Micrometers{30}, Millimeters{22}))));
  CHECK(mm_h(speed_at(*plan, Nanometers{450'000})) > at_start * 1.2);
  CHECK(mm_h(speed_at(*plan, mm(15))) > 55);
}

TEST_CASE("A slow axis brakes before a wide section and rises no faster than it can") {
  RiseBounds slow_axis = kBounds;
  slow_axis.acceleration = MillimetersPerSecondSquared{1e-5};
  const std::vector<RiseSlab> slabs =
      slabs_up_to(40, [](double height_mm) { return height_mm > 19 && height_mm < 21 ? 26.0 : 2.0; });
  const std::optional<RisePlan> plan = only_plan(slabs, slow_axis);
  REQUIRE(plan);
  CHECK(broken_law(*plan, slabs, slow_axis).empty());
  CHECK(speed_at(*plan, mm(15)) > speed_at(*plan, Nanometers{18'900'000}));
  CHECK(limit_at(*plan, Nanometers{18'000'000}) == RiseLimit::Machine);
}

TEST_CASE("A print is layered where it is too wide, and from there up to where a rise can begin") {
  const std::vector<RiseSlab> slabs = slabs_up_to(20, [](double height_mm) {
    if (height_mm > 9 && height_mm < 11) return 45.0;   // 2 mm/h through the dead zone
    if (height_mm > 11 && height_mm < 12) return 29.0;  // more than 5 mm/h, but not through the dead zone
    return 4.0;
  });
  const std::vector<RisePlan> rises = plan_rises(slabs, mm(1), kBounds);
  REQUIRE(rises.size() == 2);
  CHECK(rises[0].points.front().height == mm(1));
  CHECK(rises[0].points.back().height == mm(9));
  CHECK(rises[1].points.front().height == mm(12));
  CHECK(rises[1].points.back().height == mm(20));
  for (const RisePlan& rise : rises)
    CHECK(broken_law(rise, slabs, kBounds).empty());
}

TEST_CASE("Rises lower than a millimetre are layered, and so are slabs that are not known") {
  CHECK(plan_rises(slabs_up_to(0.9, [](double) { return 4.0; }), {}, kBounds).empty());
  CHECK(only_plan(slabs_up_to(1.0, [](double) { return 4.0; })));
  CHECK(plan_rises(slabs_up_to(9, [](double) { return kForever; }), {}, kBounds).empty());
  CHECK(plan_rises({}, {}, kBounds).empty());
  CHECK(plan_rises(slabs_up_to(9, [](double) { return 4.0; }), mm(9), kBounds).empty());
}

TEST_CASE("A rise rests where the window's oxygen is used up") {
  RiseBounds short_window = kBounds;
  short_window.window = std::chrono::minutes{10};
  const std::vector<RiseSlab> slabs = slabs_up_to(20.35, [](double) { return 4.0; });
  const std::vector<RisePlan> rises = plan_rises(slabs, {}, short_window);
  REQUIRE(rises.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(broken_law(rises[i], slabs, short_window).empty());
    CHECK(duration(with_overrun(rises[i])) <= short_window.window);
    if (i == 2) break;
    CHECK(duration(rises[i]) > std::chrono::minutes{9});
    CHECK(rises[i].points.back().height == rises[i + 1].points.front().height);
    CHECK(rises[i].points[rises[i].points.size() - 2].limit == RiseLimit::Oxygen);
  }
}

TEST_CASE("A machine that is slower than the cure holds the plan down") {
  RiseBounds slow = kBounds;
  slow.fastest = MillimetersPerSecond{10.0 / 3600};
  const std::vector<RiseSlab> slabs = slabs_up_to(5, [](double) { return 4.0; });
  const std::optional<RisePlan> plan = only_plan(slabs, slow);
  REQUIRE(plan);
  CHECK(broken_law(*plan, slabs, slow).empty());
  CHECK(mm_h(speed_at(*plan, mm(2))) == Approx(10));
  CHECK(limit_at(*plan, mm(2)) == RiseLimit::Machine);
  slow.fastest = MillimetersPerSecond{4.0 / 3600};
  CHECK(plan_rises(slabs, {}, slow).empty());
}

TEST_CASE("Plans of random prints break no law") {
  std::uint32_t state = 1;
  const auto random = [&state] { return (state = state * 1'664'525 + 1'013'904'223) / 4294967296.0; };
  for (int print = 0; print < 40; ++print) {
    RiseBounds bounds = kBounds;
    bounds.acceleration = MillimetersPerSecondSquared{std::pow(10, -5 + 6 * random())};
    bounds.margin = 2.8 + 6 * random();
    bounds.window = std::chrono::minutes{5};
    double distance_mm = 10;
    const std::vector<RiseSlab> slabs = slabs_up_to(3 + 3 * random(), [&](double) {
      if (random() < 0.2) distance_mm = 1 + 40 * random() * random();
      return distance_mm;
    });
    for (const RisePlan& rise : plan_rises(slabs, {}, bounds)) {
      CAPTURE(print, bounds.acceleration.count(), bounds.margin);
      CHECK(broken_law(rise, slabs, bounds) == "");
      CHECK(duration(with_overrun(rise)) <= bounds.window);
    }
  }
}

TEST_CASE("The plan of an hourglass is slowest at its ends") {
  const std::vector<Point> hourglass{{0, 0}, {9, 0}, {2, 4}, {8, 8}, {0, 8}};
  ContourEngine engine = engine_for(models::lathe(hourglass, 48), {kCoarseDisplay});
  RiseBounds viscous = kBounds;
  viscous.refill.viscosity_pa_s = 1.5;
  StopCheck never;
  const std::vector<RiseSlab> slabs = sweep_slabs(
      engine, {kCoarseDisplay, mm(8), slab_thickness(mm(8), Nanometers{50'000}, Micrometers{73})}, never);
  const std::optional<RisePlan> plan = only_plan(slabs, viscous, mm(1));
  REQUIRE(plan);
  CHECK(broken_law(*plan, slabs, viscous).empty());
  CHECK(speed_at(*plan, Nanometers{1'050'000}) < speed_at(*plan, mm(4)));
  CHECK(limit_at(*plan, mm(4)) == RiseLimit::Cure);
}

TEST_CASE("A rise whose bounds change holds the new laws, and speeds up only above the change") {
  const std::vector<RiseSlab> slabs = slabs_up_to(20, [](double) { return 4.0; });
  RiseBounds slow = kBounds;
  slow.fastest = MillimetersPerSecond{20.0 / 3600};
  const RisePlan before = only_plan(slabs, slow).value();
  const Nanometers from{9'930'000};
  const ChangedRise faster = change_rise(slabs, {before, from}, kBounds);
  CHECK(broken_law(faster.plan, slabs, kBounds).empty());
  CHECK(faster.plan.points.front().height == before.points.front().height);
  CHECK(faster.plan.points.back().height == mm(20));
  CHECK(mm_h(speed_at(faster.plan, from - Nanometers{1'000})) == Approx(20));
  CHECK(mm_h(speed_at(faster.plan, from + Nanometers{5'000})) == Approx(55.26).epsilon(1e-3));
  CHECK(mm_h(faster.slowest) == Approx(55.26).epsilon(1e-3));

  const ChangedRise slower = change_rise(slabs, {faster.plan, mm(15)}, slow);
  CHECK(mm_h(speed_at(slower.plan, mm(12))) == Approx(20));
  CHECK(mm_h(slower.slowest) == Approx(20));
  CHECK(slower.slowest_at == mm(15));

  // Half of the light: half of the speed, with the margin and the gap of before.
  RiseBounds dim = kBounds;
  dim.lit.irradiance = MilliwattsPerCm2{2};
  const ChangedRise dimmed = change_rise(slabs, {faster.plan, mm(15), 0.5}, dim);
  CHECK(broken_law(dimmed.plan, slabs, dim).empty());
  CHECK(mm_h(speed_at(dimmed.plan, mm(16))) == Approx(55.26 / 2).epsilon(1e-3));
}

TEST_CASE("Where resin follows slowly, a rise that may be faster waits for its gap") {
  const std::vector<RiseSlab> slabs = slabs_up_to(20, [](double) { return 22.0; });
  RiseBounds slow = kBounds;
  slow.fastest = MillimetersPerSecond{14.0 / 3600};
  const RisePlan before = only_plan(slabs, slow).value();
  const ChangedRise faster = change_rise(slabs, {before, mm(10)}, kBounds);
  CHECK(broken_law(faster.plan, slabs, kBounds).empty());
  const MillimetersPerSecond through_gap = refill_speed(
      kBounds.refill, gel_gap(kBounds.lit, margin_at(kBounds.lit, slow.fastest)), Millimeters{22});
  CHECK(speed_at(faster.plan, mm(10) + Nanometers{50'000}).count() <= through_gap.count() * 1.000001);
  CHECK(speed_at(faster.plan, mm(18)) > through_gap);
}

TEST_CASE("Random changes of random rises break no law, and nowhere speed up below the change") {
  std::uint32_t state = 7;
  const auto random = [&state] { return (state = state * 1'664'525 + 1'013'904'223) / 4294967296.0; };
  int changed = 0;
  for (int print = 0; print < 40; ++print) {
    RiseBounds bounds = kBounds;
    bounds.acceleration = MillimetersPerSecondSquared{std::pow(10, -3 + 4 * random())};
    bounds.margin = 2.8 + 6 * random();
    double distance_mm = 10;
    const std::vector<RiseSlab> slabs = slabs_up_to(3 + 3 * random(), [&](double) {
      if (random() < 0.2) distance_mm = 1 + 30 * random() * random();
      return distance_mm;
    });
    for (const RisePlan& rise : plan_rises(slabs, {}, bounds)) {
      RiseBounds other = bounds;
      const double light = random() < 0.5 ? 1 : 0.3 + random();
      other.margin = 1.2 + 10 * random();
      other.fastest = MillimetersPerSecond{0.005 + 0.1 * random()};
      other.lit.irradiance = bounds.lit.irradiance * light;
      const Nanometers bottom = rise.points.front().height, length = rise.points.back().height - bottom;
      const Nanometers from = bottom + Nanometers{std::llround(random() * in_mm(length) * 1e6)};
      const ChangedRise risen = change_rise(slabs, {rise, from, light}, other);
      CAPTURE(print, other.margin, light, in_mm(from));
      CHECK(broken_law(risen.plan, slabs, other) == "");
      CHECK(risen.plan.points.back().height == rise.points.back().height);
      const Nanometers ramp = std::max(rise.points[1].height, risen.plan.points[1].height);
      for (Nanometers height = ramp; height < from; height += Nanometers{1'777})
        if (speed_at(risen.plan, height).count() > speed_at(rise, height).count() * light * 1.000001 + 1e-9)
          FAIL_CHECK("faster than before at " << in_mm(height));
      ++changed;
    }
  }
  CHECK(changed > 20);
}
