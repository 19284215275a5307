#include "daemon/control_server.hpp"

#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using contourd::testing::TemporaryFolder;

namespace {

// A server whose every answer makes something of the machine due.
class Bench {
 public:
  Bench() {
    watch_ = watcher_.when_readable(machine_.get(), [this] {
      eventfd_t count = 0;
      ::eventfd_read(machine_.get(), &count);
      order.emplace_back("machine");
      if (requests == wanted) loop_.stop();
    });
  }

  // The order of three answers and what was due to the machine, when a client asks for these at once.
  void ask(std::string_view lines) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    const FileDescriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    REQUIRE(::connect(client.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::write(client.get(), lines.data(), lines.size()) == static_cast<ssize_t>(lines.size()));
    loop_.run();
  }

  std::vector<std::string> order;
  int requests = 0;
  static constexpr int wanted = 3;

 private:
  ControlServer::Json answer() {
    ++requests;
    order.emplace_back("request");
    ::eventfd_write(machine_.get(), 1);
    return true;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "control.sock";
  EventLoop loop_;
  EventLoopWatcher watcher_{loop_};
  FileDescriptor machine_{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  std::unique_ptr<DescriptorWatcher::Watch> watch_;
  ControlServer server_{loop_, path_, {{"ask", [this] { return answer(); }}}};
};

const std::vector<std::string> kInTurns{"request", "machine", "request", "machine", "request", "machine"};

}  // namespace

TEST_CASE("Between two requests of a client the loop sees to the machine") {
  Bench bench;
  const std::string ask = R"({"jsonrpc":"2.0","method":"ask","id":1})"
                          "\n";
  bench.ask(ask + ask + ask);
  CHECK(bench.order == kInTurns);
}

TEST_CASE("Between two requests of a batch the loop sees to the machine") {
  Bench bench;
  const std::string ask = R"({"jsonrpc":"2.0","method":"ask","id":1})";
  bench.ask("[" + ask + "," + ask + "," + ask + "]\n");
  CHECK(bench.order == kInTurns);
}
