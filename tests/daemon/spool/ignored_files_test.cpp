#include "daemon/spool/ignored_files.hpp"

#include "tests/catch.hpp"

namespace {

struct ReportedFiles final : IgnoredFilesObserver {
  void ignored(const std::string& file, WhyIgnored /*why*/) override { files.push_back(file); }
  void more_ignored(std::size_t number) override { more += number; }

  std::vector<std::string> files;
  std::size_t more = 0;
};

class IgnoredFilesFixture {
 public:
  // Runs the loop for `duration`, then calls `then`.
  void run_for(
      Duration duration, const std::function<void()>& then = [] {}) {
    const auto end = loop.at(std::chrono::steady_clock::now() + duration, "the test", [this, then] {
      then();
      loop.stop();
    });
    loop.run();
  }

  EventLoop loop;
  ReportedFiles reported;
  IgnoredFiles ignored{loop, reported, 1s};
};

// kLong is longer than the second after which a file settles; a change comes after kHalf, half of that
// second.
constexpr Duration kLong = 1300ms, kHalf = 500ms;

}  // namespace

TEST_CASE("An ignored file is reported once after some seconds, unless it goes or changes in that time") {
  IgnoredFilesFixture fixture;
  fixture.ignored.saw("stays.3mf", WhyIgnored::Model);
  fixture.ignored.saw("goes.3mf", WhyIgnored::Model);
  fixture.ignored.saw("grows", WhyIgnored::Folder);
  CHECK(fixture.ignored.files().empty());
  const auto later = fixture.loop.at(std::chrono::steady_clock::now() + kHalf, "the test", [&] {
    fixture.ignored.forget("goes.3mf");
    fixture.ignored.saw("grows", WhyIgnored::Folder);
  });
  fixture.run_for(kLong, [&] { fixture.ignored.saw("stays.3mf", WhyIgnored::Model); });
  CHECK(fixture.reported.files == std::vector<std::string>{"stays.3mf"});
  CHECK(fixture.ignored.files() == std::map<std::string, WhyIgnored>{{"stays.3mf", WhyIgnored::Model}});
  fixture.ignored.forget_all_but({"grows"});
  CHECK(fixture.ignored.files().empty());
}

TEST_CASE("The first of many ignored files are reported by name, the rest by number, and all are listed") {
  IgnoredFilesFixture fixture;
  for (int i = 0; i < 2000; ++i)
    fixture.ignored.saw("part" + std::to_string(i) + ".3mf", WhyIgnored::Model);
  fixture.run_for(kLong);
  CHECK(fixture.reported.files.size() == 10);
  CHECK(fixture.reported.more == 1990);
  CHECK(fixture.ignored.files().size() == 2000);
}
