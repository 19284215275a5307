#include "daemon/history/ended_job_notices.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

// The service manager's end.
class Listener {
 public:
  explicit Listener(const fs::path& path, int type = SOCK_STREAM, int backlog = 128)
      : socket_(::socket(AF_UNIX, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.native().copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
    REQUIRE(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    if (type == SOCK_STREAM) REQUIRE(::listen(socket_.get(), backlog) == 0);
  }

  // Takes whoever has come.
  std::size_t accept_all() {
    while (true) {
      FileDescriptor one(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      if (!one.valid()) return open.size();
      open.push_back(std::move(one));
    }
  }
  // All that was said, up to the end.
  static std::string said(const FileDescriptor& connection) {
    std::string text;
    std::array<char, 4096> bytes{};
    for (ssize_t count = 0; (count = ::read(connection.get(), bytes.data(), bytes.size())) > 0;)
      text.append(bytes.data(), static_cast<std::size_t>(count));
    return text;
  }

  std::vector<FileDescriptor> open;

 private:
  FileDescriptor socket_;
};

class Desk {
 public:
  Desk() { notices.emplace(loop, log.log, path, "Old Faithful"); }
  void end(const std::string& job) { notices->add({job, "done", ""}); }
  void end(int count) {
    for (int i = 0; i < count; ++i)
      end("job" + std::to_string(i));
  }
  // To be called once: an event loop does not run again.
  bool run_until(const std::function<bool()>& so) {
    bool reached = false;
    const auto given_up =
        loop.at(std::chrono::steady_clock::now() + 20s, "the test", [this] { loop.stop(); });
    const auto looks = loop.when_idle("the test", [&] {
      reached = so();
      if (reached) loop.stop();
      return !reached;
    });
    loop.run();
    return reached;
  }

  testing::TemporaryFolder folder;
  fs::path path = folder.path() / "ended.socket";
  EventLoop loop;
  testing::LogText log{loop};
  std::optional<EndedJobNotices> notices;
};

std::vector<std::string> values_of(const std::string& notice) {
  REQUIRE(!notice.empty());
  REQUIRE(notice.back() == '\0');
  std::vector<std::string> values;
  for (std::size_t at = 0; at < notice.size(); at += values.back().size() + 1)
    values.emplace_back(notice.c_str() + at);
  return values;
}

}  // namespace

TEST_CASE("Whoever listens is told what became of a job, and where its report is") {
  Desk desk;
  Listener listener(desk.path);
  desk.notices->add({.name = "gear",
                     .outcome = "failed",
                     .reason = "the lid is open",
                     .reports = {"/spool/gear.report.json", ""}});
  REQUIRE(listener.accept_all() == 1);
  const std::vector<std::string> values = values_of(Listener::said(listener.open[0]));
  REQUIRE(values.size() == 7);
  CHECK(values[0] == "CONTOURD_PRINTER=Old Faithful");
  CHECK(values[1] == "CONTOURD_JOB=gear");
  CHECK(values[2] == "CONTOURD_OUTCOME=failed");
  CHECK(values[3] == "CONTOURD_REASON=the lid is open");
  CHECK(values[4] == "CONTOURD_REPORT_JSON=/spool/gear.report.json");
  CHECK(values[5] == "CONTOURD_REPORT_HTML=");
  const auto json = nlohmann::json::parse(values[6].substr(std::string("CONTOURD_NOTICE=").size()));
  CHECK(json["job"] == "gear");
  CHECK(json["outcome"] == "failed");
  CHECK(json["reason"] == "the lid is open");
  CHECK(json["report_json"] == "/spool/gear.report.json");
  CHECK(json["report_html"].is_null());
}

TEST_CASE("However a job is called, its notice has the same values, a line each, and is bounded") {
  const std::string name = "x\nCONTOURD_OUTCOME=done\x1b[2J\xff\xe2\x80\xae";
  const fs::path report = "/spool/" + name + ".report.html";
  const std::string notice = notice_of(
      {.name = name, .outcome = "failed", .reason = std::string(1'000'000, 'y'), .reports = {"", report}},
      "p");
  CHECK(notice.size() < 60'000);
  const std::vector<std::string> values = values_of(notice);
  REQUIRE(values.size() == 7);
  CHECK(values[1] == "CONTOURD_JOB=x?CONTOURD_OUTCOME=done?[2J\xef\xbf\xbd?");
  CHECK(values[2] == "CONTOURD_OUTCOME=failed");
  CHECK(values[3].find("bytes more)") != std::string::npos);
  CHECK(values[5] == "CONTOURD_REPORT_HTML=" + report.native());
  for (const char c : values[6])
    CHECK((c >= 0x20 && c < 0x7F));
}

TEST_CASE("Where nobody listens nothing is kept, and nothing said") {
  Desk desk;
  desk.end(100);
  { const Listener left_behind(desk.path); }
  desk.end(100);
  fs::remove(desk.path);
  Listener listener(desk.path);
  desk.end("last");
  REQUIRE(listener.accept_all() == 1);
  CHECK(values_of(Listener::said(listener.open[0]))[1] == "CONTOURD_JOB=last");
  CHECK(desk.log.count("nobody") == 0);
}

TEST_CASE("Some jobs are told of at a time, others when these come to an end, and none is left out") {
  Desk desk;
  Listener listener(desk.path);
  desk.end(10);
  REQUIRE(listener.accept_all() == EndedJobNotices::kMostOpen);
  std::vector<std::string> told;
  CHECK(desk.run_until([&] {
    CHECK(listener.accept_all() <= EndedJobNotices::kMostOpen);
    for (const FileDescriptor& each : listener.open)
      told.push_back(values_of(Listener::said(each))[1]);
    listener.open.clear();
    return told.size() == 10;
  }));
  for (std::size_t i = 0; i < told.size(); ++i)
    CHECK(told[i] == "CONTOURD_JOB=job" + std::to_string(i));
}

TEST_CASE("Jobs that end while nothing comes to an end are told of up to a bound, which is logged once") {
  Desk desk;
  Listener listener(desk.path);
  desk.end(static_cast<int>(EndedJobNotices::kMostOpen + EndedJobNotices::kMostWaiting) + 20);
  CHECK(listener.accept_all() == EndedJobNotices::kMostOpen);
  CHECK(desk.log.count("job68: nobody is told that it has ended") == 1);
  CHECK(desk.log.count("nobody is told") == 1);
  listener.open.clear();
  std::size_t told = 0;
  CHECK(desk.run_until([&] {
    told += listener.accept_all();
    listener.open.clear();
    return told == EndedJobNotices::kMostWaiting;
  }));
}

TEST_CASE("What waits is handed over when contourd ends") {
  Desk desk;
  Listener listener(desk.path);
  desk.end(10);
  CHECK(desk.run_until([] { return true; }));
  desk.notices.reset();
  REQUIRE(listener.accept_all() == 10);
  CHECK(values_of(Listener::said(listener.open[9]))[1] == "CONTOURD_JOB=job9");
}

TEST_CASE("A listener that takes nobody is waited for, and what it says is nobody's") {
  Desk desk;
  Listener listener(desk.path, SOCK_STREAM, 0);
  desk.end(4);
  std::size_t told = 0;
  CHECK(desk.run_until([&] {
    told += listener.accept_all();
    for (const FileDescriptor& each : listener.open)
      CHECK(::send(each.get(), "hello", 5, MSG_NOSIGNAL | MSG_DONTWAIT) != 0);
    listener.open.clear();
    return told == 4;
  }));
}

TEST_CASE("A socket that cannot be used is told once, for as long as it is so") {
  Desk desk;
  {
    const Listener datagrams(desk.path, SOCK_DGRAM);
    desk.end(3);
    CHECK(desk.log.count("nobody is told of jobs that end") == 1);
  }
  fs::remove(desk.path);
  Listener listener(desk.path);
  desk.end("good");
  CHECK(listener.accept_all() == 1);
  fs::remove(desk.path);
  const Listener datagrams(desk.path, SOCK_DGRAM);
  desk.end(3);
  CHECK(desk.log.count("nobody is told of jobs that end") == 2);
}
