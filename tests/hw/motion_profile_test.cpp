#include "hw/motion_profile.hpp"

#include "tests/catch.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/random_shapes.hpp"

namespace {

// The end of a move that is stopped early.
struct EarlyStop {
  Nanometers displacement;
  Duration duration;
};

EarlyStop stopped_at(MotionProfile profile, Duration elapsed) {
  profile.stop_at(elapsed);
  return {profile.displacement(profile.duration()), profile.duration()};
}

MotionProfile profile(double distance_mm, double speed_mm_s, double acceleration_mm_s2) {
  return {mm(distance_mm), MillimetersPerSecond{speed_mm_s}, MillimetersPerSecondSquared{acceleration_mm_s2}};
}

// True if the duration is `seconds`. The tolerance is a nanosecond for rounding up, and the rounding of a
// double of seconds below 1e5: 1e-11 s.
bool lasts(Duration duration, double seconds) {
  return std::fabs(in_seconds(duration) - seconds) <= 1e-9 + 1e-11;
}

struct DrawnProfile {
  double distance_mm, speed, acceleration;
  [[nodiscard]] MotionProfile profile() const { return ::profile(distance_mm, speed, acceleration); }
};

DrawnProfile draw_profile() {
  return {draw_real(-200, 200), draw_real(0.1, 50), draw_real(1, 500)};
}

Duration draw_time(const MotionProfile& p) {
  return Duration{draw(0, p.duration().count())};
}

}  // namespace

TEST_CASE("A long move ramps up and cruises and ramps down") {
  // v/a = 0.4 s and v^2/2a = 2 mm for each ramp, 36 mm at 10 mm/s.
  const MotionProfile p = profile(40, 10, 25);
  CHECK(lasts(p.duration(), 0.4 + 3.6 + 0.4));
  CHECK(p.displacement(200ms) == mm(0.5));
  CHECK(p.displacement(400ms) == mm(2));
  CHECK(p.displacement(2200ms) == mm(20));
  CHECK(p.displacement(4000ms) == mm(38));
  CHECK(p.displacement(4200ms) == mm(39.5));
  CHECK(p.displacement(p.duration()) == mm(40));
}

TEST_CASE("A short move never reaches full speed") {
  // Top speed sqrt(d a) = 5 mm/s after 0.2 s and half a millimetre.
  const MotionProfile p = profile(1, 10, 25);
  CHECK(lasts(p.duration(), 0.4));
  CHECK(p.displacement(100ms) == mm(0.125));
  CHECK(p.displacement(200ms) == mm(0.5));
  CHECK(p.displacement(300ms) == mm(0.875));
}

TEST_CASE("A move that just reaches full speed has no cruise") {
  const MotionProfile p = profile(4, 10, 25);
  CHECK(lasts(p.duration(), 0.8));
  CHECK(p.displacement(400ms) == mm(2));
}

TEST_CASE("A move over no distance takes no time") {
  const MotionProfile p = profile(0, 10, 25);
  CHECK(p.duration() == Duration{0});
  CHECK(p.displacement(1s) == Nanometers{0});
  CHECK(stopped_at(p, 0s).displacement == Nanometers{0});
  CHECK(stopped_at(p, 1s).duration == Duration{0});
}

TEST_CASE("A move over one nanometre arrives") {
  const MotionProfile p{Nanometers{1}, MillimetersPerSecond{10}, MillimetersPerSecondSquared{25}};
  CHECK(p.displacement(p.duration()) == Nanometers{1});
  CHECK(p.duration() > Duration{0});
}

TEST_CASE("Before its start a move stands still and after its end at its whole distance") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    RC_ASSERT(p.displacement(Duration{-draw(0, 1'000'000'000)}) == Nanometers{0});
    RC_ASSERT(p.displacement(p.duration() + Duration{draw(0, 1'000'000'000)}) == mm(move.distance_mm));
    RC_ASSERT(p.displacement(p.duration()) == mm(move.distance_mm));
  }));
}

TEST_CASE("A move never goes back and never faster than its speed") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    Duration one = draw_time(p), other = draw_time(p);
    if (other < one) std::swap(one, other);
    const double sign = move.distance_mm < 0 ? -1.0 : 1.0;
    const double distance_nm =
        sign * static_cast<double>((p.displacement(other) - p.displacement(one)).count());
    RC_ASSERT(distance_nm >= 0.0);
    const double seconds = std::chrono::duration<double>(other - one).count();
    // Both ends are rounded to whole nanometres.
    RC_ASSERT(distance_nm <= move.speed * seconds * 1e6 + 1.0);
  }));
}

TEST_CASE("A move's second half mirrors its first") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    const Duration t = draw_time(p);
    const std::int64_t sum = (p.displacement(t) + p.displacement(p.duration() - t)).count();
    // Two roundings to a nanometre, and the distance in the nanosecond by which the duration is rounded up.
    RC_ASSERT(std::llabs(sum - mm(move.distance_mm).count()) <= 2);
  }));
}

TEST_CASE("A move has the duration of its formula") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const double distance = std::fabs(to_millimeters(mm(move.distance_mm)).count());
    const double v = std::fmin(move.speed, std::sqrt(distance * move.acceleration));
    RC_PRE(v > 0.0);
    RC_ASSERT(lasts(move.profile().duration(), distance / v + v / move.acceleration));
  }));
}

TEST_CASE("A faster or a stronger machine is never slower") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const Duration duration = move.profile().duration();
    // A nanosecond for rounding up.
    RC_ASSERT(profile(move.distance_mm, move.speed * 2, move.acceleration).duration() <= duration + 1ns);
    RC_ASSERT(profile(move.distance_mm, move.speed, move.acceleration * 2).duration() <= duration + 1ns);
  }));
}

TEST_CASE("A stop while cruising takes a ramp's time and distance") {
  const EarlyStop stop = stopped_at(profile(40, 10, 25), 2s);
  CHECK(stop.displacement == mm(18 + 2));
  CHECK(lasts(stop.duration, 2.4));
  const EarlyStop down = stopped_at(profile(-40, 10, 25), 2s);
  CHECK(down.displacement == mm(-20));
  CHECK(down.duration == stop.duration);
}

TEST_CASE("A stop while speeding up takes as long as it has sped up") {
  const EarlyStop stop = stopped_at(profile(40, 10, 25), 200ms);
  CHECK(stop.displacement == mm(1));
  CHECK(lasts(stop.duration, 0.4));
}

TEST_CASE("A stop while slowing down changes nothing") {
  const MotionProfile p = profile(40, 10, 25);
  for (const Duration t : {Duration{4s}, Duration{4200ms}, p.duration(), Duration{9s}}) {
    const EarlyStop stop = stopped_at(p, t);
    // The braking distance is computed in doubles and rounded to the nearest nanometre.
    CHECK(std::llabs((stop.displacement - mm(40)).count()) <= 1);
    CHECK(lasts(stop.duration, 4.4));
  }
}

TEST_CASE("A stop before the start stays at the start") {
  const EarlyStop stop = stopped_at(profile(40, 10, 25), -1s);
  CHECK(stop.displacement == Nanometers{0});
  CHECK(stop.duration == Duration{0});
}

TEST_CASE("A stop ends between where the plate is and where it was going") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    const Duration t = draw_time(p);
    const EarlyStop stop = stopped_at(p, t);
    const double sign = move.distance_mm < 0 ? -1.0 : 1.0;
    const auto forward = [sign](Nanometers distance) { return sign * static_cast<double>(distance.count()); };
    // Roundings to whole nanometres.
    RC_ASSERT(forward(stop.displacement) >= forward(p.displacement(t)) - 1.0);
    RC_ASSERT(forward(stop.displacement) <= std::fabs(move.distance_mm) * 1e6 + 1.0);
    RC_ASSERT(stop.duration >= t);
    RC_ASSERT(stop.duration <= p.duration() + 1ns);
    // Braking from v takes the time v / a, and half of v times that as distance.
    const double braking_s = std::chrono::duration<double>(stop.duration - t).count();
    const double braking_nm = move.acceleration * braking_s * braking_s / 2 * 1e6;
    // A nanosecond at 50 mm/s is 0.05 nm; the roundings of both positions.
    RC_ASSERT(std::fabs(forward(stop.displacement - p.displacement(t)) - braking_nm) <= 1.5);
  }));
}
