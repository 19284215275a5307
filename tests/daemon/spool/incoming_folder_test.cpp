#include "daemon/spool/incoming_folder.hpp"

#include <sys/epoll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

// A folder that is watched, and what is told of it.
class Desk {
 public:
  Desk() {
    source_ = loop.on_ready(inotify.get(), EPOLLIN, "inotify", [this](std::uint32_t) { read_events(); });
  }

  struct Step {
    std::function<bool()> when;  // looked at after each turn of the loop
    std::function<void()> then = [] {};
  };
  // Turns the loop until the last step is done; false when that takes longer than anything here does. Once.
  bool run(std::deque<Step> steps) {
    const auto limit = loop.at(std::chrono::steady_clock::now() + std::chrono::seconds{30}, "the limit",
                               [this] { loop.stop(); });
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
  // A file that is made in it is seen.
  [[nodiscard]] Step when_seen() {
    return {[this] { return !seen.empty(); }};
  }
  // What the disk was asked for before is told by then.
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
  std::vector<std::string> told;
  std::set<std::string> seen;  // of the files
  IncomingFolder folder{path,
                        loop,
                        disk,
                        {.make =
                             [this] {
                               if (!makes_it) throw std::runtime_error("the disk is full");
                               fs::create_directories(path);
                             },
                         .left = [this] { ++left; },
                         .replaced = [this] { ++replaced; },
                         .not_there = [this](const std::string& why) { told.push_back(why); }}};

 private:
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

std::string refusal_of(Desk& desk) {
  try {
    desk.folder.watch_by(desk.inotify.get());
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("A folder that is not there is made, and what comes into it is seen") {
  Desk desk;
  CHECK(refusal_of(desk).empty());
  CHECK(fs::is_directory(desk.path));
  CHECK(desk.run({desk.at_once([&] { desk.put("incoming/part.stl"); }), desk.when_seen()}));
  CHECK(desk.seen == std::set<std::string>{"part.stl"});
  CHECK(desk.left + desk.replaced == 0);
  CHECK_FALSE(desk.folder.is_watched_by(-1));
}

TEST_CASE("At the start a folder that cannot be watched is refused with the reason") {
  Desk desk;
  SECTION("it cannot be made") {
    desk.makes_it = false;
    CHECK(refusal_of(desk) == "the disk is full");
  }
  SECTION("a file has its name") {
    desk.put("incoming");
    CHECK_FALSE(refusal_of(desk).empty());
  }
  SECTION("it is a link to another folder") {
    fs::create_directory(desk.top.path() / "elsewhere");
    fs::create_symlink("elsewhere", desk.path);
    CHECK(refusal_of(desk).starts_with("cannot open " + desk.path.string()));
  }
  CHECK(desk.told.empty());
}

TEST_CASE("The folder that is there instead is watched, the one before no more") {
  Desk desk;
  REQUIRE(refusal_of(desk).empty());
  fs::rename(desk.path, desk.top.path() / "old");
  desk.folder.watch_anew();
  CHECK(desk.left == 1);
  CHECK(desk.run({desk.when_replaced([&] {
                    desk.put("old/late.stl");
                    desk.put("incoming/part.stl");
                  }),
                  desk.when_seen()}));
  CHECK(desk.seen == std::set<std::string>{"part.stl"});
}

TEST_CASE("A folder that is to be watched anew while it is being opened is opened once") {
  Desk desk;
  REQUIRE(refusal_of(desk).empty());
  desk.folder.watch_anew();
  desk.folder.watch_anew();
  CHECK(desk.run(desk.when_disk_is_idle([] {})));
  CHECK(desk.replaced == 1);
}

TEST_CASE("One that cannot be watched is told once, and tried again until it can be") {
  Desk desk;
  REQUIRE(refusal_of(desk).empty());
  fs::remove(desk.path);
  desk.makes_it = false;
  desk.folder.watch_anew();
  std::deque<Desk::Step> steps{{[&] { return !desk.told.empty(); }, [&] { desk.folder.watch_anew(); }}};
  for (Desk::Step& step : desk.when_disk_is_idle([&] { desk.makes_it = true; }))
    steps.push_back(std::move(step));
  steps.push_back(desk.when_replaced([&] { desk.put("incoming/part.stl"); }));
  steps.push_back(desk.when_seen());
  CHECK(desk.run(std::move(steps)));
  CHECK(desk.told == std::vector<std::string>{"the disk is full"});
}

TEST_CASE("A folder that was replaced though no event told so is seen to be another") {
  Desk desk;
  REQUIRE(refusal_of(desk).empty());
  // Nobody acts on the event here: it is as when a folder above was renamed, or a file system mounted over
  // it.
  fs::rename(desk.path, desk.top.path() / "old");
  fs::create_directory(desk.path);
  CHECK(desk.run({desk.when_replaced([&] { desk.put("incoming/part.stl"); }), desk.when_seen()}));
  CHECK(desk.left == 1);
}
