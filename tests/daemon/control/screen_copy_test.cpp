#include "daemon/control/screen_copy.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;

namespace {

constexpr Pixels kWidth{1024}, kHeight{1024};  // some turns of the loop

Mask grey_mask(std::uint8_t grey) {
  Mask mask(kWidth, kHeight);
  for (std::int32_t y = 0; y < kHeight.count(); ++y)
    std::ranges::fill(mask.row(y), grey);
  return mask;
}

class Screen : public testing::PrinterFixture {
 public:
  void ask() {
    const std::size_t number = answers.size();
    answers.emplace_back();
    copy.take([this, number](std::shared_ptr<const ScreenCopy::Picture> picture, const std::string& trouble) {
      answers[number] = {true, std::move(picture), trouble};
      most_a_turn = std::max(most_a_turn, ++this_turn);
    });
  }
  bool all_answered() {
    return std::ranges::all_of(answers, [](const Answer& answer) { return answer.there; });
  }

  struct Answer {
    bool there = false;
    std::shared_ptr<const ScreenCopy::Picture> picture;
    std::string trouble;
  };
  std::vector<Answer> answers;
  int this_turn = 0, most_a_turn = 0;
  Mask mask = grey_mask(17);
  ShownMask shown{&mask, 1, "part", 4, Nanometers{225'000}};
  std::function<void()> look = [] {};
  Worker worker{loop, "test"};
  ScreenCopy copy{loop, worker, [this] {
                    look();
                    return shown;
                  }};
};

}  // namespace

TEST_CASE("A copy of the screen has its pixels, and what they are of") {
  Screen screen;
  screen.ask();
  screen.ask();
  REQUIRE(screen.run_until([&] { return screen.all_answered(); }));
  const auto picture = screen.answers[0].picture;
  REQUIRE(picture);
  CHECK(decode_png(picture->png, kWidth, kHeight) == screen.mask);
  CHECK(picture->number == 1);
  CHECK(picture->name == "part");
  CHECK(picture->layer == 4);
  CHECK(picture->cut_at == Nanometers{225'000});
  CHECK(screen.answers[1].picture == picture);
  CHECK(screen.copy.picture(1) == picture);
  CHECK(screen.copy.picture(2) == nullptr);
}

TEST_CASE("Who asked for the same copy is told in a turn of the loop of its own") {
  Screen screen;
  screen.loop.on_turn_over([&](const EventLoop::Turn&) { screen.this_turn = 0; });
  for (int i = 0; i < 64; ++i)
    screen.ask();
  REQUIRE(screen.run_until([&] { return screen.all_answered(); }));
  CHECK(screen.most_a_turn == 1);
  CHECK(std::ranges::all_of(screen.answers, [&](const Screen::Answer& answer) {
    return answer.picture && answer.picture == screen.answers[0].picture;
  }));
  screen.loop.on_turn_over(nullptr);
}

TEST_CASE("A copy is of one mask, also when another comes in between") {
  Screen screen;
  const Mask next = grey_mask(200);
  int looks = 0;
  screen.look = [&] {
    if (++looks == 4) screen.shown = {&next, 2, "part", 5, Nanometers{275'000}};
  };
  screen.ask();
  REQUIRE(screen.run_until([&] { return screen.all_answered(); }));
  const auto picture = screen.answers[0].picture;
  REQUIRE(picture);
  CHECK(picture->number == 2);
  CHECK(picture->layer == 5);
  CHECK(decode_png(picture->png, kWidth, kHeight) == next);
}

TEST_CASE("Masks that change too fast are told, and so is that there is none") {
  Screen screen;
  SECTION("too fast") {
    screen.look = [&] { ++screen.shown.number; };
    screen.ask();
    REQUIRE(screen.run_until([&] { return screen.all_answered(); }));
    CHECK(screen.answers[0].trouble == "the masks change faster than they can be copied");
  }
  SECTION("gone in between") {
    int looks = 0;
    screen.look = [&] {
      if (++looks == 3) screen.shown.mask = nullptr;
    };
    screen.ask();
    REQUIRE(screen.run_until([&] { return screen.all_answered(); }));
    CHECK(screen.answers[0].trouble == "nothing is shown");
  }
  SECTION("none") {
    screen.shown.mask = nullptr;
    screen.ask();
    REQUIRE(screen.run_until([&] { return screen.all_answered(); }));
    CHECK(screen.answers[0].trouble == "nothing is shown");
  }
  CHECK(screen.answers[0].picture == nullptr);
  CHECK(screen.copy.picture(1) == nullptr);
}
