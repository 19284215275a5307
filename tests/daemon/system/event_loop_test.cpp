#include "daemon/system/event_loop.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "tests/catch.hpp"

namespace {

FileDescriptor readable_event() {
  return FileDescriptor(::eventfd(1, EFD_CLOEXEC | EFD_NONBLOCK));
}

}  // namespace

TEST_CASE("A watcher calls while the descriptor is readable, and stops once its watch is destroyed") {
  EventLoop loop;
  EventLoopWatcher watcher(loop);
  const FileDescriptor event = readable_event();
  int calls = 0;
  std::unique_ptr<DescriptorWatcher::Watch> watch;
  watch = watcher.when_readable(event.get(), [&] {
    if (++calls < 3) return;
    watch.reset();  // from inside its own call
    loop.stop();
  });
  loop.run();
  CHECK(calls == 3);
}

TEST_CASE("A watcher calls when the other end has hung up") {
  EventLoop loop;
  EventLoopWatcher watcher(loop);
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const FileDescriptor reader(ends[0]);
  ::close(ends[1]);
  bool called = false;
  const auto watch = watcher.when_readable(reader.get(), [&] {
    called = true;
    loop.stop();
  });
  loop.run();
  CHECK(called);
}

TEST_CASE("A descriptor that cannot be watched is refused with the kernel's reason") {
  EventLoop loop;
  EventLoopWatcher watcher(loop);
  CHECK_THROWS_AS(watcher.when_readable(-1, [] {}), std::system_error);
}

TEST_CASE("Callbacks of the machine come before clients that have waited longer") {
  EventLoop loop;
  EventLoopClock clock(loop);
  EventLoopWatcher watcher(loop);
  const FileDescriptor client = readable_event(), lid = readable_event();
  std::vector<std::string> order;
  const auto note = [&](const char* who, bool last = false) {
    order.emplace_back(who);
    if (last) loop.stop();
  };
  std::unique_ptr<EventLoop::IoSource> client_source;
  client_source =
      loop.on_ready(client.get(), EPOLLIN, "a client", [&](std::uint32_t) { note("client", true); });
  const TimePoint past = std::chrono::steady_clock::now();
  const auto pump = loop.at(past, "the spool", [&] { note("spool"); });
  const auto exposure = clock.call_at(past, [&] { note("exposure"); });
  std::unique_ptr<DescriptorWatcher::Watch> watch;
  watch = watcher.when_readable(lid.get(), [&] {
    note("lid");
    watch.reset();
  });
  loop.run();
  REQUIRE(order.size() >= 3);
  // The order of these two is not specified.
  CHECK(((order[0] == "lid" && order[1] == "exposure") || (order[0] == "exposure" && order[1] == "lid")));
}

TEST_CASE("Callbacks of the machine come between two results of a worker, not after all of them") {
  EventLoop loop;
  EventLoopWatcher watcher(loop);
  Mailbox mailbox(loop);
  const FileDescriptor lid(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  std::vector<std::string> order;
  std::unique_ptr<DescriptorWatcher::Watch> watch;
  watch = watcher.when_readable(lid.get(), [&] {
    order.emplace_back("lid");
    watch.reset();
  });
  mailbox.post([&] {
    order.emplace_back("first");
    ::eventfd_write(lid.get(), 1);
  });
  mailbox.post([&] { order.emplace_back("second"); });
  mailbox.post([&] {
    order.emplace_back("third");
    loop.stop();
  });
  loop.run();
  CHECK(order == std::vector<std::string>{"first", "lid", "second", "third"});
}

TEST_CASE("A turn is reported with the name of its source and the duration of the call") {
  EventLoop loop;
  std::vector<EventLoop::Turn> turns;
  loop.on_turn_over([&](const EventLoop::Turn& turn) { turns.push_back(turn); });
  const TimePoint now = std::chrono::steady_clock::now();
  const auto slow = loop.at(now, "a slow timer", [&loop] {
    while (loop.turn().busy < std::chrono::milliseconds(5)) {
    }
  });
  const auto last = loop.at(now + std::chrono::milliseconds(1), "the last timer", [&] { loop.stop(); });
  loop.run();
  REQUIRE(turns.size() == 2);
  CHECK(turns[0].source == "a slow timer");
  CHECK(turns[0].busy >= std::chrono::milliseconds(5));
  CHECK(turns[0].computing <=
        turns[0].busy + std::chrono::milliseconds(1));  // they are measured with two clocks
  CHECK(turns[1].source == "the last timer");
}
