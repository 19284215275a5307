#include "daemon/spool/incoming_watch.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"

using namespace contourd;
using Names = std::vector<std::string>;

namespace {

// A spool's incoming/ that is watched, and what is told of it.
class Desk : public testing::NoSpoolObserver {
 public:
  // Turns the loop until incoming/`file` has arrived, and calls `when` for every file that does. Once.
  bool run_until_arrived(const std::string& file, std::function<void(const std::string&)> when) {
    using namespace std::chrono_literals;
    when_arrived_ = [this, file, when = std::move(when)](const std::string& each) {
      when(each);
      if (each == file) loop.stop();
    };
    const auto given_up =
        loop.at(std::chrono::steady_clock::now() + 20s, "the test", [this] { loop.stop(); });
    loop.run();
    return !arrived.empty() && arrived.back() == file;
  }
  // The disk has answered all that it was asked for, and its answers are not told yet.
  void wait_for_disk() {
    std::promise<void> answered;
    disk.run(
        [&answered] {
          answered.set_value();
          return true;
        },
        [](bool) {});
    answered.get_future().wait();
  }

  testing::SpoolFixture spool;
  EventLoop loop;
  Worker disk{loop, "disk"};
  CopiedOriginals copied{spool.folder.path() / "copied-originals"};
  Names arrived, withdrawn;
  IncomingWatch watch{spool.folders, copied, [] {}, loop, disk, *this};

 private:
  void model_arrived(const std::string& file) override {
    arrived.push_back(file);
    when_arrived_(file);
  }
  void model_withdrawn(const std::string& file) override { withdrawn.push_back(file); }

  std::function<void(const std::string&)> when_arrived_;
};

}  // namespace

TEST_CASE("What a look found in a file that the spool moved away meanwhile is not told") {
  Desk desk;
  desk.spool.put("incoming/part.stl");
  desk.watch.open();
  const bool last_arrived = desk.run_until_arrived("next.stl", [&](const std::string& file) {
    if (file != "part.stl") return;
    desk.watch.wait_for("part.stl");
    desk.wait_for_disk();
    std::filesystem::rename(desk.spool.folder.path() / "incoming/part.stl",
                            desk.spool.folder.path() / "printing/part.stl");
    desk.watch.moved_away("part.stl");
    desk.spool.put("incoming/next.stl");
  });
  CHECK(last_arrived);
  CHECK(desk.arrived == Names{"part.stl", "next.stl"});
  CHECK(desk.withdrawn.empty());
}

TEST_CASE("What comes under the name of a file that the spool moved away has arrived") {
  Desk desk;
  desk.spool.put("incoming/part.stl");
  desk.watch.open();
  int times = 0;
  const bool last_arrived = desk.run_until_arrived("next.stl", [&](const std::string& file) {
    if (file != "part.stl" || ++times > 2) return;
    if (times == 1) {
      std::filesystem::rename(desk.spool.folder.path() / "incoming/part.stl",
                              desk.spool.folder.path() / "printing/part.stl");
      desk.watch.moved_away("part.stl");
      desk.spool.put("incoming/part.stl", "another model");
    } else {
      desk.spool.put("incoming/next.stl");
    }
  });
  CHECK(last_arrived);
  CHECK(times >= 2);
  CHECK(desk.withdrawn.empty());
}

TEST_CASE("What is looked at again arrives in the order in which it came, whatever the names") {
  Desk desk;
  desk.watch.open();
  // Empty files may be written yet: they are whole when nothing has changed for a while.
  const auto come = desk.loop.at(std::chrono::steady_clock::now(), "the test", [&desk] {
    desk.spool.put("incoming/z.stl", "");
    desk.spool.put("incoming/a.stl", "");
  });
  CHECK(desk.run_until_arrived("a.stl", [](const std::string&) {}));
  CHECK(desk.arrived == Names{"z.stl", "a.stl"});
}

TEST_CASE("A model arrives again when its ticket comes, changes or goes, and no other does") {
  Desk desk;
  desk.spool.put("incoming/part.stl");
  desk.spool.put("incoming/part.2.stl");
  desk.spool.put("incoming/part2.stl");
  desk.watch.open();
  const std::filesystem::path ticket = desk.spool.folder.path() / "incoming/part.json";
  int times = 0;
  const bool last_arrived = desk.run_until_arrived("next.stl", [&](const std::string& file) {
    // All three have arrived when the last of them has.
    if (times == 0 ? desk.arrived.size() < 3 : file != "part.stl") return;
    switch (++times) {
      case 1:
        return desk.spool.put("incoming/part.json", "{}");
      case 2: {
        const std::filesystem::path other = desk.spool.folder.path() / "other.json";
        desk.spool.put("other.json", "{ }");
        return std::filesystem::rename(other, ticket);
      }
      case 3:
        std::filesystem::remove(ticket);
        return;
      default:
        desk.spool.put("incoming/next.stl");
    }
  });
  CHECK(last_arrived);
  CHECK(times == 4);
  CHECK(std::ranges::count(desk.arrived, "part.stl") == 4);
  CHECK(desk.arrived.size() == 3 + 3 + 1);
  CHECK(desk.withdrawn.empty());
}
