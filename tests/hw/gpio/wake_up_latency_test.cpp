#include "hw/gpio/wake_up_latency.hpp"

#include "tests/catch.hpp"

TEST_CASE("The sustainable rate is the one at which wake-ups shift few steps and stop no motor") {
  const auto kept = [](Duration p99, Duration worst) {
    return WakeUpLatency{.count = 6'000, .p99 = p99, .worst = worst}.sustainable_rate(20'000);
  };
  CHECK(kept(0ns, 0ns) == 20'000);
  CHECK(kept(5us, 60us) == 20'000);
  CHECK(kept(50us, 60us) == Approx(10'000));  // half of 100 us
  CHECK(kept(5us, 4ms) == Approx(4'000));     // 16 intervals of 250 us
  CHECK(kept(5us, 5'001us) == 0);
}

TEST_CASE("Wake-ups are counted at their rate, and a refused priority is reported", "[threads]") {
  const TimePoint start = std::chrono::steady_clock::now();
  const WakeUpLatency latency = measure_wake_up_latency(2'000, 1'000, 100ms);  // the highest priority is 99
  CHECK(std::chrono::steady_clock::now() - start >= 100ms);
  CHECK(latency.count > 0);
  CHECK(latency.count <= 201);  // fewer if some came late
  CHECK(latency.p99 <= latency.worst);
  REQUIRE_FALSE(latency.refusals.empty());
  CHECK(latency.refusals[0].find("refuses real-time priority 1000") != std::string::npos);
}
