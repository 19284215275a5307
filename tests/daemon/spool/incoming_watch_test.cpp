#include "daemon/spool/incoming_watch.hpp"

#include <filesystem>
#include <future>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/spool/spool_fixture.hpp"
#include "tests/time_limit.hpp"

using Names = std::vector<std::string>;

namespace {

// A watched incoming/ and the reports of its watch.
class IncomingWatchFixture : public testing::NoSpoolObserver {
 public:
  // Runs the loop until incoming/`file` has arrived, and calls `when` for each file that arrives. To be
  // called once.
  bool run_until_arrived(const std::string& file, std::function<void(const std::string&)> when) {
    when_arrived_ = [this, file, when = std::move(when)](const std::string& each) {
      when(each);
      if (each == file) loop.stop();
    };
    const auto given_up =
        loop.at(std::chrono::steady_clock::now() + testing::kTimeLimit, "the test", [this] { loop.stop(); });
    loop.run();
    return !arrived.empty() && arrived.back() == file;
  }
  // Waits until the disk's thread has done all its tasks; their results have not been delivered yet.
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

TEST_CASE("A look at a file that the spool moves away meanwhile reports nothing") {
  IncomingWatchFixture fixture;
  fixture.spool.put("incoming/part.stl");
  fixture.watch.open();
  const bool last_arrived = fixture.run_until_arrived("next.stl", [&](const std::string& file) {
    if (file != "part.stl") return;
    fixture.watch.wait_for("part.stl");
    fixture.wait_for_disk();
    std::filesystem::rename(fixture.spool.folder.path() / "incoming/part.stl",
                            fixture.spool.folder.path() / "printing/part.stl");
    fixture.watch.moved_away("part.stl");
    fixture.spool.put("incoming/next.stl");
  });
  CHECK(last_arrived);
  CHECK(fixture.arrived == Names{"part.stl", "next.stl"});
  CHECK(fixture.withdrawn.empty());
}

TEST_CASE("A new file with the name of one that the spool moved away arrives") {
  IncomingWatchFixture fixture;
  fixture.spool.put("incoming/part.stl");
  fixture.watch.open();
  int times = 0;
  const bool last_arrived = fixture.run_until_arrived("next.stl", [&](const std::string& file) {
    if (file != "part.stl" || ++times > 2) return;
    if (times == 1) {
      std::filesystem::rename(fixture.spool.folder.path() / "incoming/part.stl",
                              fixture.spool.folder.path() / "printing/part.stl");
      fixture.watch.moved_away("part.stl");
      fixture.spool.put("incoming/part.stl", "another model");
    } else {
      fixture.spool.put("incoming/next.stl");
    }
  });
  CHECK(last_arrived);
  CHECK(times >= 2);
  CHECK(fixture.withdrawn.empty());
}

TEST_CASE("Files that need several looks arrive in the order in which they came, not by name") {
  IncomingWatchFixture fixture;
  fixture.watch.open();
  // Empty files may still be written: they count as complete after some time without a change.
  const auto come = fixture.loop.at(std::chrono::steady_clock::now(), "the test", [&fixture] {
    fixture.spool.put("incoming/z.stl", "");
    fixture.spool.put("incoming/a.stl", "");
  });
  CHECK(fixture.run_until_arrived("a.stl", [](const std::string&) {}));
  CHECK(fixture.arrived == Names{"z.stl", "a.stl"});
}

TEST_CASE("A model arrives again when its ticket comes, changes or goes, and no other does") {
  IncomingWatchFixture fixture;
  fixture.spool.put("incoming/part.stl");
  fixture.spool.put("incoming/part.2.stl");
  fixture.spool.put("incoming/part2.stl");
  fixture.watch.open();
  const std::filesystem::path ticket = fixture.spool.folder.path() / "incoming/part.json";
  int times = 0;
  const bool last_arrived = fixture.run_until_arrived("next.stl", [&](const std::string& file) {
    // All three have arrived when the last of them has.
    if (times == 0 ? fixture.arrived.size() < 3 : file != "part.stl") return;
    switch (++times) {
      case 1:
        return fixture.spool.put("incoming/part.json", "{}");
      case 2: {
        const std::filesystem::path other = fixture.spool.folder.path() / "other.json";
        fixture.spool.put("other.json", "{ }");
        return std::filesystem::rename(other, ticket);
      }
      case 3:
        std::filesystem::remove(ticket);
        return;
      default:
        fixture.spool.put("incoming/next.stl");
    }
  });
  CHECK(last_arrived);
  CHECK(times == 4);
  CHECK(std::ranges::count(fixture.arrived, "part.stl") == 4);
  CHECK(fixture.arrived.size() == 3 + 3 + 1);
  CHECK(fixture.withdrawn.empty());
}
