#include "daemon/event_loop.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <string>
#include <system_error>
#include <vector>

#include "tests/catch.hpp"

using namespace contourd;

namespace {

FileDescriptor readable_event() {
  return FileDescriptor(::eventfd(1, EFD_CLOEXEC | EFD_NONBLOCK));
}

}  // namespace

TEST_CASE("A watcher calls for as long as the descriptor can be read, and no longer once its watch is gone") {
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

TEST_CASE("What concerns the machine comes before clients that have waited for longer") {
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
  client_source = loop.on_ready(client.get(), EPOLLIN, [&](std::uint32_t) { note("client", true); });
  const TimePoint past = std::chrono::steady_clock::now();
  const auto pump = loop.at(past, [&] { note("spool"); });
  const auto exposure = clock.call_at(past, [&] { note("exposure"); });
  std::unique_ptr<DescriptorWatcher::Watch> watch;
  watch = watcher.when_readable(lid.get(), [&] {
    note("lid");
    watch.reset();
  });
  loop.run();
  REQUIRE(order.size() >= 3);
  // Which of the two comes first is not said.
  CHECK(((order[0] == "lid" && order[1] == "exposure") || (order[0] == "exposure" && order[1] == "lid")));
}
