// Fuzz target: any bytes to the control socket, in two portions (the first byte chooses where they are split,
// and its lowest bit whether the first line exceeds the limit). Every answer is a JSON-RPC message in ASCII,
// there are at most as many answers as lines, and a valid request at the end is answered.
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/control/control_server.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::fuzz {
namespace {

using Json = ControlMethod::Json;

constexpr std::string_view kLast = "{\"jsonrpc\":\"2.0\",\"method\":\"status\",\"id\":\"the last\"}\n";
// A user may send 200 requests at once; requests beyond that wait for real time.
constexpr std::ptrdiff_t kMaxTurns = 190;

ControlMethods methods() {
  const ControlParameter value = ControlParameter::text("value", ""),
                         other = ControlParameter::number("other", -1, 1, "", "");
  return {{"status",
           {.call =
                [](const Json&, const ControlCaller&) {
                  return Json{{"state", "idle"}};
                }}},
          {"echo",
           {.parameters = {value, other},
            .call =
                [](const Json& parameters, const ControlCaller& caller) {
                  demand(caller.connection == 1, "a connection has a wrong number");
                  return parameters;
                }}},
          {"pause", {.call = [](const Json&, const ControlCaller&) -> Json {
             throw ControlRefusal("there is no print to pause");
           }}},
          {"set",
           {.parameters = {value},
            .call = [](const Json&, const ControlCaller&) -> Json {
              throw InvalidParameters("it is out of range");
            }}},
          {"fail", {.call = [](const Json&, const ControlCaller&) -> Json {
             throw std::runtime_error("no such \xFF thing");
           }}}};
}

// A client in the server's own loop: sends everything, and reads until the server closes.
class Talk {
 public:
  Talk(EventLoop& loop, const std::string& socket, std::string first, std::string second)
      : loop_(loop),
        socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
        second_(std::move(second)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, socket.c_str(), socket.size() + 1);
    demand(::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0,
           "the connection failed");
    say(first);
    source_ = loop.on_ready(socket_.get(), EPOLLIN, "the client", [this](std::uint32_t) { hear(); });
    rest_ = loop.at(std::chrono::steady_clock::now(), "the client's rest", [this] {
      say(second_);
      ::shutdown(socket_.get(), SHUT_WR);
    });
  }

  [[nodiscard]] const std::string& heard() const { return heard_; }

 private:
  void say(const std::string& bytes) {
    const auto sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    demand(sent == static_cast<ssize_t>(bytes.size()), "the socket does not take all bytes");
  }
  void hear() {
    std::array<char, 4096> buffer;
    const ssize_t bytes = ::read(socket_.get(), buffer.data(), buffer.size());
    if (bytes > 0) {
      heard_.append(buffer.data(), static_cast<std::size_t>(bytes));
      return;
    }
    source_->set_events(0);
    loop_.stop();
  }

  EventLoop& loop_;
  FileDescriptor socket_;
  std::string second_, heard_;
  std::unique_ptr<EventLoop::IoSource> source_;
  EventLoop::SourcePtr rest_;
};

void demand_answer(const Json& message) {
  demand(message.is_object() && message.value("jsonrpc", "") == "2.0", "an answer is not a JSON-RPC message");
  demand(message.contains("id"), "an answer has no id");
  demand(message.contains("result") != message.contains("error"),
         "an answer is neither a result nor an error");
  if (!message.contains("error")) return;
  const Json& error = message["error"];
  demand(error.at("code").is_number_integer() && !error.at("message").get<std::string>().empty(),
         "an error has no code or no message");
}

// Checks the answers and returns their number.
std::ptrdiff_t demand_answers(std::string_view heard) {
  demand(std::ranges::all_of(heard, [](char byte) { return byte == '\n' || (byte >= ' ' && byte <= '~'); }),
         "an answer is not ASCII");
  std::ptrdiff_t lines = 0;
  Json last;
  for (; !heard.empty(); ++lines) {
    const std::size_t end = heard.find('\n');
    demand(end != std::string_view::npos, "an answer has no end");
    last = Json::parse(heard.substr(0, end), nullptr, false);
    demand(!last.is_discarded(), "an answer is not JSON");
    demand(!last.is_array() || !last.empty(), "an answer to nothing");
    for (const Json& each : last.is_array() ? last : Json::array({last}))
      demand_answer(each);
    heard.remove_prefix(end + 1);
  }
  demand(last.is_object() && last.value("id", Json()) == "the last" && last.contains("result"),
         "the last request is not answered");
  return lines;
}

// Returns the number of lines that are not blank.
std::ptrdiff_t lines_in(std::string_view bytes) {
  std::ptrdiff_t lines = 0;
  while (!bytes.empty()) {
    const std::string_view line = bytes.substr(0, bytes.find('\n'));
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) ++lines;
    bytes.remove_prefix(std::min(line.size() + 1, bytes.size()));
  }
  return lines;
}

void check(std::uint8_t shape, std::string bytes) {
  const auto count = [&](char wanted) { return std::ranges::count(bytes, wanted); };
  if (count('\n') + count(',') > kMaxTurns) return;
  static const testing::TemporaryFolder folder;
  const std::string socket = (folder.path() / "control.sock").string();
  if ((shape & 1U) != 0) bytes.insert(0, 20'000, ' ');
  bytes += '\n';
  const std::size_t part = bytes.size() * shape / 256;
  EventLoop loop;
  ControlServer server(loop, socket, methods());
  Talk talk(loop, socket, bytes.substr(0, part), bytes.substr(part) + std::string(kLast));
  loop.run();
  // A line that is too long is answered even if it is blank.
  const bool is_blank = (shape & 1U) != 0 && lines_in(bytes.substr(0, bytes.find('\n'))) == 0;
  demand(demand_answers(talk.heard()) <= lines_in(bytes) + (is_blank ? 1 : 0) + 1,
         "there are more answers than lines");
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0)
    contourd::fuzz::check(data[0], std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  return 0;
}
