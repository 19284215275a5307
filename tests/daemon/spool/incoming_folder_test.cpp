#include "daemon/spool/incoming_folder.hpp"

#include <sys/epoll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <atomic>
#include <deque>
#include <filesystem>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/time_limit.hpp"

namespace fs = std::filesystem;

namespace {

// A watched folder and the calls that its watch makes.
class IncomingFolderFixture : private IncomingFolderObserver {
 public:
  IncomingFolderFixture() {
    source_ = loop.on_ready(inotify.get(), EPOLLIN, "inotify", [this](std::uint32_t) { read_events(); });
  }

  struct Step {
    std::function<bool()> when;  // checked after each turn of the loop
    std::function<void()> then = [] {};
  };
  // Runs the loop until the last step is done; false after kTimeLimit. To be called once.
  bool run(std::deque<Step> steps) {
    const auto limit =
        loop.at(std::chrono::steady_clock::now() + testing::kTimeLimit, "the limit", [this] { loop.stop(); });
    const auto begin = loop.at(std::chrono::steady_clock::now(), "the begin", [] {});
    loop.on_turn_over([&](const EventLoop::Turn&) {
      while (!steps.empty() && steps.front().when()) {
        steps.front().then();
        steps.pop_front();
      }
      if (steps.empty()) loop.stop();
    });
    loop.run();
    return steps.empty();
  }
  [[nodiscard]] Step at_once(std::function<void()> then) const {
    return {[] { return true; }, std::move(then)};
  }
  [[nodiscard]] Step when_replaced(std::function<void()> then) {
    return {[this] { return replaced > 0; }, std::move(then)};
  }
  void put(const std::string& file) const { (void)top.write(file, ""); }
  // Returns the step that waits until a new file in the folder has been seen.
  [[nodiscard]] Step when_seen() {
    return {[this] { return !seen.empty(); }};
  }
  // Returns the steps that call `then` after the disk's thread has done its earlier tasks.
  [[nodiscard]] std::deque<Step> when_disk_is_idle(std::function<void()> then) {
    return {at_once([this] { disk.run([] { return true; }, [this](bool) { disk_is_idle = true; }); }),
            {[this] { return disk_is_idle; }, std::move(then)}};
  }

  testing::TemporaryFolder top;
  const fs::path path = top.path() / "incoming";
  EventLoop loop;
  Worker disk{loop, "disk"};
  FileDescriptor inotify{::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)};
  std::atomic<bool> makes_it = true;  // read by the disk's thread
  bool disk_is_idle = false;
  int left = 0, replaced = 0;
  std::vector<std::string> errors;
  std::set<std::string> seen;  // names of files
  IncomingFolder folder{path, loop, disk, *this};

 private:
  void make_folder() override {
    if (!makes_it) throw std::runtime_error("the disk is full");
    fs::create_directories(path);
  }
  void folder_left() override { ++left; }
  void folder_replaced() override { ++replaced; }
  void folder_lost(const std::string& why) override { errors.push_back(why); }

  void read_events() {
    alignas(inotify_event) std::array<char, 4096> buffer;
    const ssize_t bytes = ::read(inotify.get(), buffer.data(), buffer.size());
    for (ssize_t at = 0; at < bytes;) {
      const auto* const event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
      if (event->len > 0 && folder.is_watched_by(event->wd)) seen.insert(event->name);
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    }
  }

  std::unique_ptr<EventLoop::IoSource> source_;
};

std::string refusal_of(IncomingFolderFixture& fixture) {
  try {
    fixture.folder.watch_by(fixture.inotify.get());
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("A folder that does not exist is made, and new files in it are seen") {
  IncomingFolderFixture fixture;
  CHECK(refusal_of(fixture).empty());
  CHECK(fs::is_directory(fixture.path));
  CHECK(fixture.run({fixture.at_once([&] { fixture.put("incoming/part.stl"); }), fixture.when_seen()}));
  CHECK(fixture.seen == std::set<std::string>{"part.stl"});
  CHECK(fixture.left + fixture.replaced == 0);
  CHECK_FALSE(fixture.folder.is_watched_by(-1));
}

TEST_CASE("At the start a folder that cannot be watched is refused with the reason") {
  IncomingFolderFixture fixture;
  SECTION("it cannot be made") {
    fixture.makes_it = false;
    CHECK(refusal_of(fixture) == "the disk is full");
  }
  SECTION("a file has its name") {
    fixture.put("incoming");
    CHECK_FALSE(refusal_of(fixture).empty());
  }
  SECTION("it is a link to another folder") {
    fs::create_directory(fixture.top.path() / "elsewhere");
    fs::create_symlink("elsewhere", fixture.path);
    CHECK(refusal_of(fixture).starts_with("cannot open " + fixture.path.string()));
  }
  CHECK(fixture.errors.empty());
}

TEST_CASE("A replacement folder is watched, and the previous one no longer is") {
  IncomingFolderFixture fixture;
  REQUIRE(refusal_of(fixture).empty());
  fs::rename(fixture.path, fixture.top.path() / "old");
  fixture.folder.watch_anew();
  CHECK(fixture.left == 1);
  CHECK(fixture.run({fixture.when_replaced([&] {
                       fixture.put("old/late.stl");
                       fixture.put("incoming/part.stl");
                     }),
                     fixture.when_seen()}));
  CHECK(fixture.seen == std::set<std::string>{"part.stl"});
}

TEST_CASE("A second request to watch the folder again while it is being opened opens it once") {
  IncomingFolderFixture fixture;
  REQUIRE(refusal_of(fixture).empty());
  fixture.folder.watch_anew();
  fixture.folder.watch_anew();
  CHECK(fixture.run(fixture.when_disk_is_idle([] {})));
  CHECK(fixture.replaced == 1);
}

TEST_CASE("A folder that cannot be watched is reported once and retried until it can") {
  IncomingFolderFixture fixture;
  REQUIRE(refusal_of(fixture).empty());
  fs::remove(fixture.path);
  fixture.makes_it = false;
  fixture.folder.watch_anew();
  std::deque<IncomingFolderFixture::Step> steps{
      {[&] { return !fixture.errors.empty(); }, [&] { fixture.folder.watch_anew(); }}};
  for (IncomingFolderFixture::Step& step : fixture.when_disk_is_idle([&] { fixture.makes_it = true; }))
    steps.push_back(std::move(step));
  steps.push_back(fixture.when_replaced([&] { fixture.put("incoming/part.stl"); }));
  steps.push_back(fixture.when_seen());
  CHECK(fixture.run(std::move(steps)));
  CHECK(fixture.errors == std::vector<std::string>{"the disk is full"});
}

TEST_CASE("A folder that was replaced without an event is noticed") {
  IncomingFolderFixture fixture;
  REQUIRE(refusal_of(fixture).empty());
  // This test ignores the event, as if a folder above had been renamed, or a file system mounted over the
  // folder.
  fs::rename(fixture.path, fixture.top.path() / "old");
  fs::create_directory(fixture.path);
  CHECK(fixture.run({fixture.when_replaced([&] { fixture.put("incoming/part.stl"); }), fixture.when_seen()}));
  CHECK(fixture.left == 1);
}
