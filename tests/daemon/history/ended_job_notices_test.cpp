#include "daemon/history/ended_job_notices.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "hw/file_descriptor.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

// The service manager's end of the socket.
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

  // Accepts all waiting connections; returns the number of open ones.
  std::size_t accept_all() {
    while (true) {
      FileDescriptor one(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      if (!one.valid()) return open.size();
      open.push_back(std::move(one));
    }
  }
  // Returns everything that was sent, up to the end of the stream.
  static std::string received(const FileDescriptor& connection) {
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

class EndedJobNoticesFixture {
 public:
  EndedJobNoticesFixture() {
    notices.emplace(loop, log.log, path, "Old Faithful", [this](std::int64_t key) { sent.push_back(key); });
  }
  void end(const std::string& job) {
    EndedJob ended{.name = job, .outcome = "done", .reason = ""};
    ended.key = ++last_key;
    notices->add(ended);
  }
  void end(int count) {
    for (int i = 0; i < count; ++i)
      end("job" + std::to_string(i));
  }
  bool run_until(const std::function<bool()>& so) { return testing::run_loop_until(loop, so); }

  testing::TemporaryFolder folder;
  fs::path path = folder.path() / "ended.socket";
  EventLoop loop;
  testing::LogText log{loop};
  std::int64_t last_key = 0;
  std::vector<std::int64_t> sent;  // keys of jobs
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

TEST_CASE("A notice contains the job's outcome and the paths of its report") {
  EndedJobNoticesFixture fixture;
  Listener listener(fixture.path);
  fixture.notices->add({.name = "gear",
                        .outcome = "failed",
                        .reason = "the lid is open",
                        .reports = {"/spool/gear.report.json", ""}});
  REQUIRE(listener.accept_all() == 1);
  const std::vector<std::string> values = values_of(Listener::received(listener.open[0]));
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

TEST_CASE("A notice has the same single-line values and a bounded size for any job name") {
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

TEST_CASE("Without a listener no notice is kept and nothing is logged") {
  EndedJobNoticesFixture fixture;
  fixture.end(100);
  { const Listener closed(fixture.path); }
  fixture.end(100);
  fs::remove(fixture.path);
  Listener listener(fixture.path);
  CHECK(fixture.sent.size() == 200);
  fixture.end("last");
  REQUIRE(listener.accept_all() == 1);
  CHECK(values_of(Listener::received(listener.open[0]))[1] == "CONTOURD_JOB=last");
  CHECK(fixture.log.count("notice") == 0);
}

TEST_CASE("A few notices are open at a time, the others follow, and none is lost") {
  EndedJobNoticesFixture fixture;
  Listener listener(fixture.path);
  fixture.end(10);
  REQUIRE(listener.accept_all() == EndedJobNotices::kMostOpen);
  std::vector<std::string> notices_seen;
  CHECK(fixture.run_until([&] {
    CHECK(listener.accept_all() <= EndedJobNotices::kMostOpen);
    for (const FileDescriptor& each : listener.open)
      notices_seen.push_back(values_of(Listener::received(each))[1]);
    listener.open.clear();
    return notices_seen.size() == 10;
  }));
  for (std::size_t i = 0; i < notices_seen.size(); ++i)
    CHECK(notices_seen[i] == "CONTOURD_JOB=job" + std::to_string(i));
}

TEST_CASE("A bounded number of notices waits for connections to close, and the first lost one is logged") {
  EndedJobNoticesFixture fixture;
  Listener listener(fixture.path);
  fixture.end(static_cast<int>(EndedJobNotices::kMostOpen + EndedJobNotices::kMostWaiting) + 20);
  CHECK(listener.accept_all() == EndedJobNotices::kMostOpen);
  CHECK(fixture.log.count("job68: no notice is sent of its end") == 1);
  CHECK(fixture.sent == std::vector<std::int64_t>{1, 2, 3, 4});
  CHECK(fixture.log.count("no notice is sent") == 1);
  listener.open.clear();
  std::size_t notices_seen = 0;
  CHECK(fixture.run_until([&] {
    notices_seen += listener.accept_all();
    listener.open.clear();
    return notices_seen == EndedJobNotices::kMostWaiting;
  }));
  CHECK(fixture.sent.size() == EndedJobNotices::kMostOpen + EndedJobNotices::kMostWaiting);
}

TEST_CASE("Waiting notices are sent when contourd ends") {
  EndedJobNoticesFixture fixture;
  Listener listener(fixture.path);
  fixture.end(10);
  CHECK(fixture.run_until([] { return true; }));
  fixture.notices.reset();
  REQUIRE(listener.accept_all() == 10);
  CHECK(values_of(Listener::received(listener.open[9]))[1] == "CONTOURD_JOB=job9");
}

TEST_CASE("Notices wait for a slow listener, and its replies are not read") {
  EndedJobNoticesFixture fixture;
  Listener listener(fixture.path, SOCK_STREAM, 0);
  fixture.end(4);
  std::size_t notices_seen = 0;
  CHECK(fixture.run_until([&] {
    notices_seen += listener.accept_all();
    for (const FileDescriptor& each : listener.open)
      CHECK(::send(each.get(), "hello", 5, MSG_NOSIGNAL | MSG_DONTWAIT) != 0);
    listener.open.clear();
    return notices_seen == 4;
  }));
}

TEST_CASE("A socket that cannot be used is logged once until it works again") {
  EndedJobNoticesFixture fixture;
  {
    const Listener datagrams(fixture.path, SOCK_DGRAM);
    fixture.end(3);
    CHECK(fixture.log.count("cannot send notices of ended jobs") == 1);
  }
  fs::remove(fixture.path);
  Listener listener(fixture.path);
  fixture.end("good");
  CHECK(listener.accept_all() == 1);
  fs::remove(fixture.path);
  const Listener datagrams(fixture.path, SOCK_DGRAM);
  fixture.end(3);
  CHECK(fixture.log.count("cannot send notices of ended jobs") == 2);
}
