#include "hw/gpio/wake_ups.hpp"

#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::Approx;

TEST_CASE("A computer keeps the speed at which its wake-ups shift few steps and stop no motor") {
  const auto kept = [](Duration p99, Duration worst) {
    return WakeUps{.count = 6'000, .p99 = p99, .worst = worst}.kept_rate(20'000);
  };
  CHECK(kept(0ns, 0ns) == 20'000);
  CHECK(kept(5us, 60us) == 20'000);
  CHECK(kept(50us, 60us) == Approx(10'000));  // half of 100 us
  CHECK(kept(5us, 4ms) == Approx(4'000));     // 16 intervals of 250 us
  CHECK(kept(5us, 5'001us) == 0);
}

TEST_CASE("Wake-ups are counted at their rate, and a priority that is refused is told", "[threads]") {
  const TimePoint start = std::chrono::steady_clock::now();
  const WakeUps wake_ups = measure_wake_ups(2'000, 1'000, 100ms);  // there is no priority above 99
  CHECK(std::chrono::steady_clock::now() - start >= 100ms);
  CHECK(wake_ups.count > 0);
  CHECK(wake_ups.count <= 201);  // fewer where they came late
  CHECK(wake_ups.p99 <= wake_ups.worst);
  REQUIRE_FALSE(wake_ups.refusals.empty());
  CHECK(wake_ups.refusals[0].find("refuses real-time priority 1000") != std::string::npos);
}
