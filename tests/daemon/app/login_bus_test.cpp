// Tests LoginBus with a fake message bus and logind, at the address of the system bus for this process.
#include "daemon/app/login_bus.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace {

// A message bus with a logind, served by the test's own event loop.
class FakeBus {
 public:
  FakeBus(EventLoop& loop, const std::string& path) : loop_(loop) {
    listener_ = FileDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    REQUIRE(::bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(listener_.get(), 4) == 0);
    REQUIRE(::setenv("DBUS_SYSTEM_BUS_ADDRESS", ("unix:path=" + path).c_str(), 1) == 0);
    accepting_ = loop.on_ready(listener_.get(), POLLIN, "the bus", [this](std::uint32_t) { accept(); });
  }
  ~FakeBus() {
    ::unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
    sd_bus_close_unref(bus_);
  }

  void prepare_for_sleep(bool asleep) {
    sd_bus_message* signal = nullptr;
    REQUIRE(sd_bus_message_new_signal(bus_, &signal, "/org/freedesktop/login1",
                                      "org.freedesktop.login1.Manager", "PrepareForSleep") >= 0);
    sd_bus_message_set_sender(signal, "org.freedesktop.login1");
    sd_bus_message_append(signal, "b", asleep ? 1 : 0);
    CHECK(sd_bus_send(bus_, signal, nullptr) >= 0);
    sd_bus_message_unref(signal);
  }

  std::vector<std::string> modes;  // requested with Inhibit
  std::string refuses;             // the mode that is refused
  FileDescriptor lock;             // logind's end of the last lock

 private:
  void accept() {
    const int client = ::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    REQUIRE(client >= 0);
    sd_id128_t id{};
    id.bytes[0] = 1;
    REQUIRE(sd_bus_new(&bus_) >= 0);
    REQUIRE(sd_bus_set_fd(bus_, client, client) >= 0);
    REQUIRE(sd_bus_set_server(bus_, 1, id) >= 0);
    REQUIRE(sd_bus_negotiate_fds(bus_, 1) >= 0);
    REQUIRE(sd_bus_set_anonymous(bus_, 1) >= 0);
    REQUIRE(sd_bus_add_filter(bus_, nullptr, serve, this) >= 0);
    REQUIRE(sd_bus_start(bus_) >= 0);
    loop_.attach(bus_);
  }

  static int serve(sd_bus_message* message, void* self, sd_bus_error*) {
    auto& bus = *static_cast<FakeBus*>(self);
    if (sd_bus_message_is_method_call(message, nullptr, "Hello") > 0)
      return sd_bus_reply_method_return(message, "s", ":1.1");
    if (sd_bus_message_is_method_call(message, nullptr, "AddMatch") > 0)
      return sd_bus_reply_method_return(message, "");
    if (sd_bus_message_is_method_call(message, "org.freedesktop.login1.Manager", "Inhibit") > 0)
      return bus.inhibit(message);
    return 0;
  }

  int inhibit(sd_bus_message* message) {
    const char *what = nullptr, *who = nullptr, *why = nullptr, *mode = nullptr;
    REQUIRE(sd_bus_message_read(message, "ssss", &what, &who, &why, &mode) >= 0);
    CHECK(std::string(what) == "sleep");
    CHECK(std::string(who) == "contourd");
    modes.emplace_back(mode);
    if (mode == refuses)
      return sd_bus_reply_method_errorf(message, "org.freedesktop.DBus.Error.AccessDenied",
                                        "Permission denied");
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    lock = FileDescriptor(ends[0]);
    const FileDescriptor given(ends[1]);
    return sd_bus_reply_method_return(message, "h", given.get());
  }

  EventLoop& loop_;
  FileDescriptor listener_;
  std::unique_ptr<EventLoop::IoSource> accepting_;
  sd_bus* bus_ = nullptr;
};

bool open_at_the_other_end(const FileDescriptor& pipe) {
  pollfd hung_up{pipe.get(), POLLIN, 0};
  return ::poll(&hung_up, 1, 0) == 0;
}

}  // namespace

TEST_CASE("Locks are requested by mode and held until they are closed, and a refusal has logind's message") {
  const testing::TemporaryFolder folder;
  EventLoop loop;
  FakeBus bus(loop, (folder.path() / "bus").string());
  bus.refuses = "block";
  LoginBus login(loop);
  FileDescriptor lock;
  std::string refusal;
  login.take(SleepAuthority::Lock::Block, [&](FileDescriptor taken, const std::string& why) {
    CHECK_FALSE(taken.valid());
    refusal = why;
  });
  login.take(SleepAuthority::Lock::Delay, [&](FileDescriptor taken, const std::string& why) {
    CHECK(why.empty());
    lock = std::move(taken);
    loop.stop();
  });
  CHECK(bus.modes.empty());  // take() has not blocked
  loop.run();
  CHECK(bus.modes == std::vector<std::string>{"block", "delay"});
  CHECK(refusal == "Permission denied");
  REQUIRE(lock.valid());
  CHECK(open_at_the_other_end(bus.lock));
  lock = FileDescriptor();
  CHECK_FALSE(open_at_the_other_end(bus.lock));
}

TEST_CASE("The handler is called before the computer sleeps and after it has woken") {
  const testing::TemporaryFolder folder;
  EventLoop loop;
  FakeBus bus(loop, (folder.path() / "bus").string());
  LoginBus login(loop);
  std::vector<bool> calls;
  login.on_sleep([&](bool asleep) {
    calls.push_back(asleep);
    if (calls.size() == 2) loop.stop();
  });
  // The answer to this request implies that the match, requested before, is in place.
  login.take(SleepAuthority::Lock::Delay, [&](FileDescriptor, const std::string&) {
    bus.prepare_for_sleep(true);
    bus.prepare_for_sleep(false);
  });
  loop.run();
  CHECK(calls == std::vector<bool>{true, false});
}

TEST_CASE("Without a message bus every lock is refused, from the event loop") {
  const testing::TemporaryFolder folder;
  REQUIRE(::setenv("DBUS_SYSTEM_BUS_ADDRESS", ("unix:path=" + (folder.path() / "none").string()).c_str(),
                   1) == 0);
  EventLoop loop;
  LoginBus login(loop);
  std::string refusal;
  login.take(SleepAuthority::Lock::Delay, [&](FileDescriptor lock, const std::string& why) {
    CHECK_FALSE(lock.valid());
    refusal = why;
    loop.stop();
  });
  CHECK(refusal.empty());
  loop.run();
  CHECK(refusal.find("No such file") != std::string::npos);
  ::unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
}
