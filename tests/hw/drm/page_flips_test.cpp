#include "hw/drm/page_flips.hpp"

#include <cerrno>
#include <random>

#include "tests/catch.hpp"

namespace {

constexpr std::uint32_t kBlack = 40, kFirst = 41, kSecond = 42, kThird = 43;

// Accepts flips like the kernel, one at a time; a flip is done when the test calls refresh().
class ScriptedCrtc final : public Crtc {
 public:
  std::uint32_t on_screen = kBlack;
  std::optional<std::uint32_t> coming;
  std::uint64_t serial = 0;
  int refusal = 0;

  // Performs the refresh after a flip. Returns the flip's serial.
  std::uint64_t refresh() {
    if (coming) on_screen = *coming;
    coming.reset();
    return serial;
  }

  [[nodiscard]] std::uint32_t id() const noexcept override { return 1; }
  [[nodiscard]] bool is_atomic() const noexcept override { return true; }
  [[nodiscard]] int test_mode(std::uint32_t) noexcept override { return 0; }
  [[nodiscard]] int set_mode(std::uint32_t picture) noexcept override {
    on_screen = picture;
    coming.reset();
    return 0;
  }
  [[nodiscard]] int flip(std::uint32_t picture, std::uint64_t with) noexcept override {
    if (refusal != 0) return refusal;
    if (coming) return EBUSY;
    coming = picture;
    serial = with;
    return 0;
  }
  int turn_off() noexcept override { return 0; }
};

TimePoint at(Duration since_start) {
  return TimePoint{} + since_start;
}

struct Screen {
  ScriptedCrtc crtc;
  PageFlips flips{kBlack, {kFirst, kSecond}};

  void show_mask(TimePoint now = at(0ms)) {
    (void)flips.mask_to_write();
    REQUIRE(flips.show_written(crtc, now) == 0);
  }
  std::optional<PageFlips::Done> refresh() { return flips.finish(crtc, crtc.refresh(), at(0ms)); }
};

}  // namespace

TEST_CASE("The kernel may take ten refreshes to confirm a flip, but at least 250 ms") {
  CHECK(flip_deadline(16'666'667ns) == 250ms);
  CHECK(flip_deadline(41'666'667ns) == 416'666'670ns);  // 24 Hz
  CHECK(flip_deadline(0ns) == 250ms);
}

TEST_CASE("A mask is on the screen when the kernel confirms it, and the next is written to another buffer") {
  Screen screen;
  CHECK_FALSE(screen.flips.waiting_since());
  CHECK(screen.flips.mask_to_write() == 0);
  screen.show_mask(at(5ms));
  CHECK(screen.flips.waiting_since() == at(5ms));
  CHECK(screen.crtc.coming == kFirst);
  CHECK(screen.refresh()->all);
  CHECK_FALSE(screen.flips.waiting_since());
  CHECK(screen.flips.mask_to_write() == 1);
}

TEST_CASE("With three masks, the mask that has just left the screen is not written") {
  ScriptedCrtc crtc;
  PageFlips flips(kBlack, {kFirst, kSecond, kThird});
  std::vector<std::size_t> written;
  for (int i = 0; i < 6; ++i) {
    written.push_back(flips.mask_to_write());
    REQUIRE(flips.show_written(crtc, at(0ms)) == 0);
    REQUIRE(flips.finish(crtc, crtc.refresh(), at(0ms)));
  }
  CHECK(written == std::vector<std::size_t>{0, 1, 2, 0, 1, 2});
}

TEST_CASE("A picture requested while a flip is pending comes after it, and is pending from then on") {
  Screen screen;
  screen.show_mask(at(0ms));
  REQUIRE(screen.flips.show_black(screen.crtc, at(10ms)) == 0);
  CHECK(screen.flips.waiting_since() == at(0ms));
  const auto first = screen.flips.finish(screen.crtc, screen.crtc.refresh(), at(16ms));
  REQUIRE(first);
  CHECK_FALSE(first->all);
  CHECK(screen.flips.waiting_since() == at(16ms));
  CHECK(screen.refresh()->all);
  CHECK(screen.crtc.on_screen == kBlack);
}

TEST_CASE("black_now() requests black, or names the mask whose flip cannot be cancelled") {
  Screen screen;
  SECTION("with a mask on the screen") {
    screen.show_mask();
    REQUIRE(screen.refresh());
    const auto blackout = screen.flips.black_now(screen.crtc, at(1ms));
    CHECK(blackout.error == 0);
    CHECK_FALSE(blackout.mask_under_way);
    CHECK(screen.flips.waiting_since() == at(1ms));
  }
  SECTION("with a mask's flip pending") {
    screen.show_mask();
    CHECK(screen.flips.black_now(screen.crtc, at(1ms)).mask_under_way == 0);
    CHECK(screen.flips.black_now(screen.crtc, at(2ms)).mask_under_way == 0);  // a second call
    CHECK_FALSE(screen.refresh()->all);
  }
  SECTION("with black's flip pending and a mask queued after it") {
    screen.show_mask();
    REQUIRE(screen.refresh());
    REQUIRE(screen.flips.show_black(screen.crtc, at(1ms)) == 0);
    screen.show_mask();
    const auto blackout = screen.flips.black_now(screen.crtc, at(2ms));
    CHECK(blackout.error == 0);
    CHECK_FALSE(blackout.mask_under_way);
  }
  (void)screen.refresh();
  (void)screen.refresh();
  CHECK_FALSE(screen.flips.waiting_since());
  CHECK(screen.crtc.on_screen == kBlack);
}

TEST_CASE("black_now() on a black screen makes no request to the kernel") {
  Screen screen;
  screen.crtc.refusal = EACCES;
  CHECK(screen.flips.black_now(screen.crtc, at(0ms)).error == 0);
}

TEST_CASE("A refused flip is reported, whether it is refused at once or after it was queued") {
  Screen screen;
  screen.show_mask();
  REQUIRE(screen.refresh());
  screen.crtc.refusal = EACCES;
  CHECK(screen.flips.show_black(screen.crtc, at(0ms)) == EACCES);
  CHECK(screen.flips.black_now(screen.crtc, at(0ms)).error == EACCES);
  CHECK_FALSE(screen.flips.waiting_since());

  screen.crtc.refusal = 0;
  screen.show_mask();
  REQUIRE(screen.flips.show_black(screen.crtc, at(0ms)) == 0);
  screen.crtc.refusal = ENODEV;
  const auto done = screen.refresh();
  REQUIRE(done);
  CHECK(done->error == ENODEV);
  CHECK_FALSE(done->all);
}

TEST_CASE("After a lost event the screen can be used again, and the late event is ignored") {
  Screen screen;
  screen.show_mask(at(0ms));
  const std::uint64_t lost = screen.crtc.refresh();
  CHECK(screen.flips.waiting_since() == at(0ms));  // forever

  (void)screen.crtc.set_mode(kBlack);
  screen.flips.reset();
  CHECK_FALSE(screen.flips.waiting_since());
  CHECK_FALSE(screen.flips.finish(screen.crtc, lost, at(300ms)));

  screen.show_mask(at(400ms));
  CHECK_FALSE(screen.flips.finish(screen.crtc, lost, at(401ms)));
  CHECK(screen.flips.waiting_since() == at(400ms));
  const auto done = screen.refresh();
  REQUIRE(done);
  CHECK(done->all);
}

TEST_CASE("After any sequence of requests the last one is shown, and no visible mask is ever written") {
  std::mt19937 random(1);
  for (int run = 0; run < 2000; ++run) {
    Screen screen;
    std::optional<std::uint32_t> wanted = kBlack;
    for (int i = 0; i < 40; ++i) {
      switch (random() % 5) {
        case 0: {
          const bool may_write = !screen.flips.waiting_since();  // as show() requires
          if (!may_write) break;
          const std::uint32_t written = kFirst + static_cast<std::uint32_t>(screen.flips.mask_to_write());
          REQUIRE(written != screen.crtc.on_screen);
          REQUIRE(screen.flips.show_written(screen.crtc, at(0ms)) == 0);
          wanted = written;
          break;
        }
        case 1:
          REQUIRE(screen.flips.show_black(screen.crtc, at(0ms)) == 0);
          wanted = kBlack;
          break;
        case 2:
          REQUIRE(screen.flips.black_now(screen.crtc, at(0ms)).error == 0);
          wanted = kBlack;
          break;
        case 3:
          (void)screen.refresh();
          break;
        case 4:
          // The event is lost or has an old serial.
          (void)screen.crtc.refresh();
          (void)screen.flips.finish(screen.crtc, screen.crtc.serial - 1, at(0ms));
          if (!screen.flips.waiting_since()) break;
          (void)screen.crtc.set_mode(kBlack);
          screen.flips.reset();
          wanted = kBlack;
          break;
      }
    }
    for (int i = 0; i < 3; ++i)
      (void)screen.refresh();
    REQUIRE(screen.crtc.on_screen == wanted);
    REQUIRE_FALSE(screen.flips.waiting_since());
  }
}
