// A made-up message bus with a made-up logind, at the address that the system's bus has for this process.
#include "daemon/app/login_bus.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;

namespace {

// On the test's own loop: each side is served as the loop turns.
class MadeUpBus {
 public:
  MadeUpBus(EventLoop& loop, const std::string& path) : loop_(loop) {
    listener_ = FileDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    REQUIRE(::bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(listener_.get(), 4) == 0);
    REQUIRE(::setenv("DBUS_SYSTEM_BUS_ADDRESS", ("unix:path=" + path).c_str(), 1) == 0);
    accepting_ = loop.on_ready(listener_.get(), POLLIN, "the bus", [this](std::uint32_t) { accept(); });
  }
  ~MadeUpBus() {
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

  std::vector<std::string> modes;  // of Inhibit
  std::string refuses;             // this one
  FileDescriptor lock;             // the end that logind keeps of the last

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
    auto& bus = *static_cast<MadeUpBus*>(self);
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

TEST_CASE("logind's locks are asked for by mode, held as long as they are kept, and refused in its words") {
  const testing::TemporaryFolder folder;
  EventLoop loop;
  MadeUpBus bus(loop, (folder.path() / "bus").string());
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
  CHECK(bus.modes.empty());  // nothing has waited for an answer
  loop.run();
  CHECK(bus.modes == std::vector<std::string>{"block", "delay"});
  CHECK(refusal == "Permission denied");
  REQUIRE(lock.valid());
  CHECK(open_at_the_other_end(bus.lock));
  lock = FileDescriptor();
  CHECK_FALSE(open_at_the_other_end(bus.lock));
}

TEST_CASE("That the computer goes to sleep, and that it has woken, is heard") {
  const testing::TemporaryFolder folder;
  EventLoop loop;
  MadeUpBus bus(loop, (folder.path() / "bus").string());
  LoginBus login(loop);
  std::vector<bool> heard;
  login.on_sleep([&](bool asleep) {
    heard.push_back(asleep);
    if (heard.size() == 2) loop.stop();
  });
  // When this is answered, the match before it is in place.
  login.take(SleepAuthority::Lock::Delay, [&](FileDescriptor, const std::string&) {
    bus.prepare_for_sleep(true);
    bus.prepare_for_sleep(false);
  });
  loop.run();
  CHECK(heard == std::vector<bool>{true, false});
}

TEST_CASE("Where there is no message bus every lock is refused, from the event loop") {
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
