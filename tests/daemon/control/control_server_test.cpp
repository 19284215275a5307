#include "daemon/control/control_server.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/time_limit.hpp"

namespace {

// A server whose every answer triggers an event of the machine.
class ControlServerFixture {
 public:
  ControlServerFixture() {
    watch_ = watcher_.when_readable(machine_.get(), [this] {
      eventfd_t count = 0;
      ::eventfd_read(machine_.get(), &count);
      order.emplace_back("machine");
      if (requests == kWanted) loop.stop();
    });
  }

  // Sends three requests at once; `order` then has the sequence of answers and machine events.
  void ask(std::string_view lines) {
    const FileDescriptor client = connect();
    REQUIRE(::write(client.get(), lines.data(), lines.size()) == static_cast<ssize_t>(lines.size()));
    loop.run();
  }

  [[nodiscard]] FileDescriptor connect() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    FileDescriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    REQUIRE(::connect(client.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    return client;
  }

  EventLoop loop;
  std::vector<std::string> order;
  int requests = 0;
  static constexpr int kWanted = 3;

 private:
  ControlServer::Json answer() {
    ++requests;
    order.emplace_back("request");
    ::eventfd_write(machine_.get(), 1);
    return true;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "control.sock";
  EventLoopWatcher watcher_{loop};
  FileDescriptor machine_{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  std::unique_ptr<DescriptorWatcher::Watch> watch_;
  ControlServer server_{
      loop,
      path_,
      {{"ask", {.call = [this](const ControlServer::Json&, const ControlCaller&) { return answer(); }}}}};
};

// Returns the reply of a method that takes "height" and "speed" and returns its parameters.
std::string reply_to(const std::string& parameters) {
  EventLoop loop;
  const TemporaryFolder folder;
  const auto give_back = [](const ControlServer::Json& given, const ControlCaller&) {
    if (given.contains("height") && given["height"] == 0) throw InvalidParameters("a height is above 0");
    return given;
  };
  const ControlServer server(loop, folder.path() / "control.sock",
                             {{"move",
                               {.parameters = {ControlParameter::number("height", -10, 10, "mm", ""),
                                               ControlParameter::number("speed", 1, 5, "mm/s", "")},
                                .call = give_back}}});
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  (folder.path() / "control.sock").string().copy(address.sun_path, sizeof address.sun_path - 1);
  const FileDescriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  REQUIRE(::connect(client.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const std::string request = R"({"jsonrpc":"2.0","method":"move","params":)" + parameters + ",\"id\":1}\n";
  REQUIRE(::write(client.get(), request.data(), request.size()) > 0);
  std::string reply(1000, '\0');
  const auto answered = loop.on_ready(client.get(), EPOLLIN, "the test", [&](std::uint32_t) {
    reply.resize(
        static_cast<std::size_t>(std::max<ssize_t>(::read(client.get(), reply.data(), reply.size()), 0)));
    loop.stop();
  });
  loop.run();
  return reply;
}

const std::vector<std::string> kInTurns{"request", "machine", "request", "machine", "request", "machine"};

}  // namespace

TEST_CASE("The loop serves the machine between two requests of a client") {
  ControlServerFixture fixture;
  const std::string ask = R"({"jsonrpc":"2.0","method":"ask","id":1})"
                          "\n";
  fixture.ask(ask + ask + ask);
  CHECK(fixture.order == kInTurns);
}

TEST_CASE("The loop serves the machine between two requests of a batch") {
  ControlServerFixture fixture;
  const std::string ask = R"({"jsonrpc":"2.0","method":"ask","id":1})";
  fixture.ask("[" + ask + "," + ask + "," + ask + "]\n");
  CHECK(fixture.order == kInTurns);
}

TEST_CASE(
    "A connection without a free descriptor does not keep the loop busy, and is accepted when one is free") {
  ControlServerFixture fixture;
  const FileDescriptor client = fixture.connect();
  const std::string ask = R"({"jsonrpc":"2.0","method":"ask","id":1})"
                          "\n";
  REQUIRE(::write(client.get(), (ask + ask + ask).data(), 3 * ask.size()) > 0);
  rlimit limit{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &limit) == 0);
  const rlimit none{0, limit.rlim_max};
  int turns = 0, turns_without = 0;
  fixture.loop.on_turn_over(
      [&](const EventLoop::Turn& turn) { turns += turn.source == "the control socket" ? 1 : 0; });
  const auto later = fixture.loop.at(std::chrono::steady_clock::now() + 100ms, "the test", [&] {
    turns_without = turns;
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &limit) == 0);
  });
  REQUIRE(::setrlimit(RLIMIT_NOFILE, &none) == 0);
  fixture.loop.run();
  CHECK(turns_without == 1);
  CHECK(fixture.order == kInTurns);
}

TEST_CASE("A method gets the given parameters, or none") {
  CHECK(reply_to(R"({"height":3,"speed":1})") ==
        "{\"jsonrpc\":\"2.0\",\"result\":{\"height\":3,\"speed\":1},\"id\":1}\n");
  for (const char* none : {"{}", "[]", "null"})
    CHECK(reply_to(none) == "{\"jsonrpc\":\"2.0\",\"result\":{},\"id\":1}\n");
}

TEST_CASE("Unknown parameters and invalid values are refused") {
  const auto refusal = [](const std::string& parameters) {
    const auto reply = ControlServer::Json::parse(reply_to(parameters));
    CHECK(reply["error"]["code"] == -32602);
    return reply["error"]["message"].get<std::string>();
  };
  CHECK(refusal(R"({"height":3,"depth":1})") ==
        R"(the method "move" has no parameter "depth"; there are height, speed)");
  CHECK(refusal("[3]") == R"(the method "move" takes its parameters by name: height, speed)");
  CHECK(refusal(R"({"height":0})") == "a height is above 0");
  CHECK(refusal(R"({"speed":6})") == "speed must be a number from 1 to 5 mm/s");
}

TEST_CASE("A closed connection is reported once, by the number that its methods got") {
  EventLoop loop;
  const TemporaryFolder folder;
  std::vector<std::uint64_t> calls, gone;
  ControlServer server(loop, folder.path() / "control.sock",
                       {{"ask", {.call = [&](const ControlServer::Json&, const ControlCaller& caller) {
                           calls.push_back(caller.connection);
                           return ControlServer::Json(true);
                         }}}});
  server.on_disconnected([&](std::uint64_t connection) {
    gone.push_back(connection);
    loop.stop();
  });
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  (folder.path() / "control.sock").string().copy(address.sun_path, sizeof address.sun_path - 1);
  const FileDescriptor stays(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  REQUIRE(::connect(stays.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  {
    const FileDescriptor goes(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    REQUIRE(::connect(goes.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    const std::string ask = R"({"jsonrpc":"2.0","method":"ask","id":1})"
                            "\n";
    REQUIRE(::write(goes.get(), ask.data(), ask.size()) > 0);
  }
  loop.run();
  CHECK(calls == std::vector<std::uint64_t>{2});
  CHECK(gone == calls);
}

namespace {

// A server that answers the method "later" when the test calls `waiting`, and "now" at once; and a client.
class DeferredAnswerFixture {
 public:
  explicit DeferredAnswerFixture(std::string_view lines) {
    server_.on_disconnected([this](std::uint64_t) { disconnected = true; });
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    REQUIRE(::connect(client.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::write(client.get(), lines.data(), lines.size()) == static_cast<ssize_t>(lines.size()));
  }
  // Runs until the condition is true and returns what the client has read. May be called only once.
  template <typename Condition>
  std::string run_until(Condition done) {
    std::string read;
    const auto end = std::chrono::steady_clock::now() + testing::kTimeLimit;
    const auto look = loop.when_idle("the test", [&] {
      char buffer[4096];
      const ssize_t bytes = ::recv(client.get(), buffer, sizeof buffer, MSG_DONTWAIT);
      if (bytes > 0) read.append(buffer, static_cast<std::size_t>(bytes));
      if (done(read) || std::chrono::steady_clock::now() > end) loop.stop();
      return true;
    });
    loop.run();
    return read;
  }

  EventLoop loop;
  std::vector<ControlMethod::Later> waiting;
  int answered_now = 0;
  bool disconnected = false;
  FileDescriptor client{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};

 private:
  [[nodiscard]] ControlMethods methods() {
    ControlMethod deferred;
    deferred.call_later = [this](const ControlServer::Json&, const ControlCaller&,
                                 ControlMethod::Later later) { waiting.push_back(std::move(later)); };
    ControlMethod at_once;
    at_once.call_later = [](const ControlServer::Json& given, const ControlCaller&,
                            const ControlMethod::Later& later) {
      if (given.empty()) return later("at once");
      later(ControlRefusal("refused at once"));
    };
    at_once.parameters = {ControlParameter::flag("refused", "true for a refusal")};
    return {{"later", deferred},
            {"at once", at_once},
            {"now",
             {.call = [this](const ControlServer::Json&, const ControlCaller&) { return ++answered_now; }}}};
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "control.sock";
  ControlServer server_{loop, path_, methods()};
};

}  // namespace

TEST_CASE("A client gets its answers in order, including deferred ones, alone or in a batch") {
  DeferredAnswerFixture fixture(R"({"jsonrpc":"2.0","method":"later","id":1}
{"jsonrpc":"2.0","method":"later"}
[{"jsonrpc":"2.0","method":"later","id":2},{"jsonrpc":"2.0","method":"now","id":3}]
{"jsonrpc":"2.0","method":"now","id":4}
)");
  int at_first = -1;
  std::size_t answered = 0;
  const std::string read = fixture.run_until([&](const std::string& all) {
    if (fixture.waiting.size() > answered) {
      if (at_first < 0) at_first = fixture.answered_now;
      fixture.waiting[answered++]("done");
    }
    return std::ranges::count(all, '\n') == 3;
  });
  CHECK(at_first == 0);
  CHECK(answered == 3);
  CHECK(read == R"({"jsonrpc":"2.0","result":"done","id":1}
[{"jsonrpc":"2.0","result":"done","id":2},{"jsonrpc":"2.0","result":1,"id":3}]
{"jsonrpc":"2.0","result":2,"id":4}
)");
}

TEST_CASE("A method that can defer its answer may also answer at once, and the next request follows") {
  DeferredAnswerFixture fixture(R"({"jsonrpc":"2.0","method":"at once","id":1}
{"jsonrpc":"2.0","method":"at once"}
{"jsonrpc":"2.0","method":"at once","params":{"refused":true},"id":2}
[{"jsonrpc":"2.0","method":"at once","id":3},{"jsonrpc":"2.0","method":"now","id":4}]
{"jsonrpc":"2.0","method":"now","id":5}
)");
  const std::string read =
      fixture.run_until([](const std::string& all) { return std::ranges::count(all, '\n') == 4; });
  CHECK(read == R"({"jsonrpc":"2.0","result":"at once","id":1}
{"jsonrpc":"2.0","error":{"code":-32000,"message":"refused at once"},"id":2}
[{"jsonrpc":"2.0","result":"at once","id":3},{"jsonrpc":"2.0","result":1,"id":4}]
{"jsonrpc":"2.0","result":2,"id":5}
)");
}

TEST_CASE("A closed connection is noticed at once, even while it waits for an answer") {
  DeferredAnswerFixture fixture("{\"jsonrpc\":\"2.0\",\"method\":\"later\",\"id\":1}\n");
  fixture.run_until([&](const std::string&) {
    if (!fixture.waiting.empty() && fixture.client.valid()) fixture.client = FileDescriptor();
    return fixture.disconnected;
  });
  CHECK(fixture.disconnected);
  REQUIRE(fixture.waiting.size() == 1);
  fixture.waiting[0]("done");  // no one gets the answer
}
