#include "daemon/control/screen_copy.hpp"

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace {

constexpr Pixels kWidth{1024}, kHeight{1024};  // copied in several turns of the loop

Mask grey_mask(std::uint8_t grey) {
  Mask mask(kWidth, kHeight);
  for (std::int32_t y = 0; y < kHeight.count(); ++y)
    std::ranges::fill(mask.row(y), grey);
  return mask;
}

class ScreenCopyFixture : public testing::PrinterFixture {
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

TEST_CASE("A copy of the screen has its pixels and their description") {
  ScreenCopyFixture fixture;
  fixture.ask();
  fixture.ask();
  REQUIRE(fixture.run_until([&] { return fixture.all_answered(); }));
  const auto picture = fixture.answers[0].picture;
  REQUIRE(picture);
  CHECK(decode_png(picture->png, kWidth, kHeight) == fixture.mask);
  CHECK(picture->number == 1);
  CHECK(picture->name == "part");
  CHECK(picture->layer == 4);
  CHECK(picture->cut_at == Nanometers{225'000});
  CHECK(fixture.answers[1].picture == picture);
  CHECK(fixture.copy.picture(1) == picture);
  CHECK(fixture.copy.picture(2) == nullptr);
}

TEST_CASE("Each request for the same copy is answered in its own turn of the loop") {
  ScreenCopyFixture fixture;
  fixture.loop.on_turn_over([&](const EventLoop::Turn&) { fixture.this_turn = 0; });
  for (int i = 0; i < 64; ++i)
    fixture.ask();
  REQUIRE(fixture.run_until([&] { return fixture.all_answered(); }));
  CHECK(fixture.most_a_turn == 1);
  CHECK(std::ranges::all_of(fixture.answers, [&](const ScreenCopyFixture::Answer& answer) {
    return answer.picture && answer.picture == fixture.answers[0].picture;
  }));
  fixture.loop.on_turn_over(nullptr);
}

TEST_CASE("A copy contains a single mask, even if the mask changes meanwhile") {
  ScreenCopyFixture fixture;
  const Mask next = grey_mask(200);
  int looks = 0;
  fixture.look = [&] {
    if (++looks == 4) fixture.shown = {&next, 2, "part", 5, Nanometers{275'000}};
  };
  fixture.ask();
  REQUIRE(fixture.run_until([&] { return fixture.all_answered(); }));
  const auto picture = fixture.answers[0].picture;
  REQUIRE(picture);
  CHECK(picture->number == 2);
  CHECK(picture->layer == 5);
  CHECK(decode_png(picture->png, kWidth, kHeight) == next);
}

TEST_CASE("A copy fails if the masks change too fast or nothing is shown") {
  ScreenCopyFixture fixture;
  SECTION("the masks change too fast") {
    fixture.look = [&] { ++fixture.shown.number; };
    fixture.ask();
    REQUIRE(fixture.run_until([&] { return fixture.all_answered(); }));
    CHECK(fixture.answers[0].trouble == "the masks change faster than they can be copied");
  }
  SECTION("the mask disappears meanwhile") {
    int looks = 0;
    fixture.look = [&] {
      if (++looks == 3) fixture.shown.mask = nullptr;
    };
    fixture.ask();
    REQUIRE(fixture.run_until([&] { return fixture.all_answered(); }));
    CHECK(fixture.answers[0].trouble == "nothing is shown");
  }
  SECTION("nothing is shown") {
    fixture.shown.mask = nullptr;
    fixture.ask();
    REQUIRE(fixture.run_until([&] { return fixture.all_answered(); }));
    CHECK(fixture.answers[0].trouble == "nothing is shown");
  }
  CHECK(fixture.answers[0].picture == nullptr);
  CHECK(fixture.copy.picture(1) == nullptr);
}
