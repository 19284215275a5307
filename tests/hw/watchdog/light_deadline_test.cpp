#include "hw/watchdog/light_deadline.hpp"

#include "tests/catch.hpp"

namespace {

constexpr TimePoint kStart{1h};

WatchedExposure exposure(Duration end, bool off_asked = false, std::uint64_t number = 1) {
  return {number, kStart + end, off_asked};
}

// Returns a deadline that watches this exposure from the start.
LightDeadline armed(const WatchedExposure& watched, std::optional<Duration> gap = {}) {
  LightDeadline deadline;
  if (gap) deadline.set_gap(*gap);
  deadline.arm(watched, kStart, kStart);
  return deadline;
}

struct Done {
  Duration at;
  LightDeadline::Act act;
};
// Returns the actions from one time to another, when due() is called at next().
std::vector<Done> run(LightDeadline& deadline, Duration from, Duration until) {
  std::vector<Done> all;
  for (TimePoint now = kStart + from; now <= kStart + until;) {
    const LightDeadline::Act act = deadline.due(now);
    const bool acts = act.light_off || act.display_black || act.trip != LightTrip::None || act.end;
    if (acts) all.push_back({now - kStart, act});
    if (act.end) break;
    const auto next = deadline.next();
    if (!next) break;
    REQUIRE((acts || *next > now));  // otherwise this loop would not end
    now = std::max(*next, now);
  }
  return all;
}

// Sends heartbeats every 50 ms in [from, until].
std::vector<Done> run_with_beats(LightDeadline& deadline, const WatchedExposure& watched, Duration from,
                                 Duration until) {
  std::vector<Done> all;
  for (Duration at = from; at <= until; at += 50ms) {
    deadline.heartbeat(watched, kStart + at, kStart + at);
    for (const Done& done : run(deadline, at, at + 49ms))
      all.push_back(done);
  }
  return all;
}

}  // namespace

TEST_CASE("A light watchdog with no exposure to watch does nothing, and ends when the daemon does") {
  LightDeadline deadline;
  CHECK_FALSE(deadline.next());
  CHECK(run(deadline, 0ms, 1h).empty());
  deadline.daemon_is_gone();
  const auto done = run(deadline, 0ms, 1h);
  REQUIRE(done.size() == 1);
  CHECK(done[0].act.end);
  CHECK_FALSE(done[0].act.light_off);
}

TEST_CASE("An exposure that ends in time is left alone while the daemon is alive") {
  LightDeadline deadline = armed(exposure(2s));
  CHECK(run_with_beats(deadline, exposure(2s), 0ms, 2s).empty());
  CHECK(run_with_beats(deadline, exposure(2s, true), 2s, 30s).empty());  // a slow projector confirms
  deadline.disarm(1);
  CHECK(run(deadline, 30s, 1h).empty());
}

TEST_CASE("The light goes off 200 ms after the last sign of life, three times, the screen with the second") {
  LightDeadline deadline = armed(exposure(10s), 108ms);
  CHECK(run_with_beats(deadline, exposure(10s), 0ms, 1s).empty());
  const auto done = run(deadline, 1s, 1900ms);
  REQUIRE(done.size() == 3);
  CHECK(done[0].at == 1200ms);
  CHECK(done[0].act.light_off);
  CHECK(done[0].act.trip == LightTrip::Silence);
  CHECK_FALSE(done[0].act.display_black);
  CHECK(done[1].at == 1308ms);
  CHECK(done[1].act.light_off);
  CHECK(done[1].act.display_black);
  CHECK(done[1].act.trip == LightTrip::None);
  CHECK(done[2].at == 1416ms);
  CHECK(done[2].act.light_off);
  CHECK_FALSE(done[2].act.end);
}

TEST_CASE("Light off is repeated every second while the daemon is silent, and no more once it is back") {
  LightDeadline deadline = armed(exposure(10s), 100ms);
  CHECK(run(deadline, 0ms, 5450ms).size() == 8);  // at 0.2, 0.3, 0.4, 1.4 ... 5.4 s
  CHECK(run_with_beats(deadline, exposure(10s, true), 5500ms, 60s).empty());
  // The exposure is still watched.
  const auto again = run(deadline, 60050ms, 63s);
  CHECK(again.size() >= 2);
  for (const Done& done : again)
    CHECK(done.act.trip == LightTrip::None);  // the trip has been reported already
}

TEST_CASE("Light off is sent three times even if the daemon is back at once: one may have been in the gap") {
  LightDeadline deadline = armed(exposure(10s), 100ms);
  CHECK(deadline.due(kStart + 200ms).trip == LightTrip::Silence);
  CHECK(run_with_beats(deadline, exposure(10s, true), 250ms, 10s).size() == 2);
}

TEST_CASE("The daemon's death turns the light off at once, and ends the watchdog after three light offs") {
  for (const bool off_asked : {false, true}) {
    LightDeadline deadline = armed(exposure(10s, off_asked), 100ms);
    deadline.daemon_is_gone();
    const auto done = run(deadline, 0ms, 1h);
    REQUIRE(done.size() == 3);
    CHECK(done[0].at == 0ms);
    CHECK(done[0].act.trip == LightTrip::Death);
    CHECK(done[1].act.display_black);
    CHECK(done[2].at == 200ms);
    CHECK(done[2].act.light_off);
    CHECK(done[2].act.end);
  }
}

TEST_CASE("A daemon that dies after it fell silent is not waited for") {
  LightDeadline deadline = armed(exposure(10s));
  CHECK(run(deadline, 0ms, 20s).size() > 3);
  deadline.daemon_is_gone();
  const auto done = run(deadline, 20s, 1h);
  REQUIRE_FALSE(done.empty());
  CHECK(done[0].at == 20s);
  CHECK(done[0].act.end);
}

TEST_CASE("The light of a live daemon is turned off 250 ms after the exposure's end if it is still on") {
  LightDeadline deadline = armed(exposure(2s));
  CHECK(run_with_beats(deadline, exposure(2s), 0ms, 2150ms).empty());
  const auto done = run_with_beats(deadline, exposure(2s), 2200ms, 2300ms);
  REQUIRE_FALSE(done.empty());
  CHECK(done[0].at == 2250ms);
  CHECK(done[0].act.trip == LightTrip::Overrun);
}

TEST_CASE("The deadline moves with the exposure's end, which counts from when light on is sent") {
  LightDeadline deadline = armed(exposure(2s));
  CHECK(run_with_beats(deadline, exposure(3s), 0ms, 3200ms).empty());
  CHECK(run_with_beats(deadline, exposure(3s), 3250ms, 3250ms)[0].act.trip == LightTrip::Overrun);
}

TEST_CASE("Messages that were delayed are no sign of life, nor are messages from the future") {
  LightDeadline deadline = armed(exposure(10s));
  deadline.heartbeat(exposure(10s), kStart + 10ms, kStart + 199ms);
  CHECK(run(deadline, 199ms, 209ms).empty());
  CHECK(deadline.due(kStart + 210ms).trip == LightTrip::Silence);

  LightDeadline another;
  another.arm(exposure(10s), kStart + 5s, kStart);
  another.heartbeat(exposure(10s), kStart + 5s, kStart + 10ms);
  CHECK(another.due(kStart + 210ms).trip == LightTrip::Silence);

  LightDeadline third;
  third.arm(exposure(10s), kStart, kStart + 100ms);
  CHECK(third.due(kStart + 200ms).trip == LightTrip::Silence);
}

TEST_CASE("Messages about another exposure neither keep a watch alive nor end it") {
  LightDeadline deadline = armed(exposure(10s, false, 7));
  deadline.heartbeat(exposure(10s, true, 6), kStart + 150ms, kStart + 150ms);
  deadline.disarm(6);
  CHECK(deadline.exposure() == 7);
  CHECK(deadline.due(kStart + 200ms).trip == LightTrip::Silence);
}

TEST_CASE("A watchdog that has turned a light off watches the next exposure like the first") {
  LightDeadline deadline = armed(exposure(10s));
  CHECK_FALSE(run(deadline, 0ms, 300ms).empty());
  deadline.disarm(1);
  CHECK(run(deadline, 301ms, 5s).empty());
  deadline.arm(exposure(20s, false, 2), kStart + 5s, kStart + 5s);
  CHECK(run(deadline, 5s, 5199ms).empty());
  CHECK(deadline.due(kStart + 5200ms).trip == LightTrip::Silence);
}

TEST_CASE("An exposure that is confirmed dark while light off is repeated gets no further light off") {
  LightDeadline deadline = armed(exposure(10s), 100ms);
  CHECK(deadline.due(kStart + 200ms).light_off);
  deadline.disarm(1);
  CHECK(run(deadline, 201ms, 1h).empty());
}
