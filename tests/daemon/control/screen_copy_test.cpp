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

TEST_CASE_METHOD(ScreenCopyFixture, "A copy of the screen has its pixels and their description") {
  ask();
  ask();
  REQUIRE(run_until([&] { return all_answered(); }));
  const auto picture = answers[0].picture;
  REQUIRE(picture);
  CHECK(decode_png(picture->png, kWidth, kHeight) == mask);
  CHECK(picture->number == 1);
  CHECK(picture->name == "part");
  CHECK(picture->layer == 4);
  CHECK(picture->cut_at == Nanometers{225'000});
  CHECK(answers[1].picture == picture);
  CHECK(copy.picture(1) == picture);
  CHECK(copy.picture(2) == nullptr);
}

TEST_CASE_METHOD(ScreenCopyFixture,
                 "Each request for the same copy is answered in its own turn of the loop") {
  loop.on_turn_over([&](const EventLoop::Turn&) { this_turn = 0; });
  for (int i = 0; i < 64; ++i)
    ask();
  REQUIRE(run_until([&] { return all_answered(); }));
  CHECK(most_a_turn == 1);
  CHECK(std::ranges::all_of(answers, [&](const ScreenCopyFixture::Answer& answer) {
    return answer.picture && answer.picture == answers[0].picture;
  }));
  loop.on_turn_over(nullptr);
}

TEST_CASE_METHOD(ScreenCopyFixture, "A copy contains a single mask, even if the mask changes meanwhile") {
  const Mask next = grey_mask(200);
  int looks = 0;
  look = [&] {
    if (++looks == 4) shown = {&next, 2, "part", 5, Nanometers{275'000}};
  };
  ask();
  REQUIRE(run_until([&] { return all_answered(); }));
  const auto picture = answers[0].picture;
  REQUIRE(picture);
  CHECK(picture->number == 2);
  CHECK(picture->layer == 5);
  CHECK(decode_png(picture->png, kWidth, kHeight) == next);
}

TEST_CASE_METHOD(ScreenCopyFixture, "A copy fails if the masks change too fast or nothing is shown") {
  SECTION("the masks change too fast") {
    look = [&] { ++shown.number; };
    ask();
    REQUIRE(run_until([&] { return all_answered(); }));
    CHECK(answers[0].trouble == "the masks change faster than they can be copied");
  }
  SECTION("the mask disappears meanwhile") {
    int looks = 0;
    look = [&] {
      if (++looks == 3) shown.mask = nullptr;
    };
    ask();
    REQUIRE(run_until([&] { return all_answered(); }));
    CHECK(answers[0].trouble == "nothing is shown");
  }
  SECTION("nothing is shown") {
    shown.mask = nullptr;
    ask();
    REQUIRE(run_until([&] { return all_answered(); }));
    CHECK(answers[0].trouble == "nothing is shown");
  }
  CHECK(answers[0].picture == nullptr);
  CHECK(copy.picture(1) == nullptr);
}
