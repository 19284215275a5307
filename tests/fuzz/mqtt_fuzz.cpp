// Fuzz target: an MQTT broker that sends any messages, or any bytes, to contourd-web once it has been
// greeted. The first byte chooses: bit 0, contourd refuses every call; bit 1, the rest are the broker's bytes
// as they are; bit 2, the broker has kept all messages. A message is a byte with the length of its topic, one
// with that of its payload, and both. contourd-web sends valid packets, publishes its own topics only, calls
// no method but its own, at most kMostCommands commands at once, and none that a broker has kept.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/web/mqtt/home_assistant_link.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/fake_printer.hpp"
#include "tests/fuzz/quiet_log.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::fuzz {
namespace {

using namespace std::string_view_literals;

// The broker's answers to CONNECT, and to SUBSCRIBE with two topics as message 1 (MQTT 3.1.1, 3.2 and 3.9).
constexpr std::string_view kConnected = "\x20\x02\x00\x00"sv, kSubscribed = "\x90\x04\x00\x01\x00\x00"sv;
// Real time for a connection that does not end.
constexpr std::chrono::milliseconds kPatience{500};
// Real time in which the messages arrive, and their commands reach contourd; those that do not are not
// counted.
constexpr std::chrono::milliseconds kSettling{10};

std::string length_of(std::size_t bytes) {
  std::string text;
  do {
    const std::size_t more = bytes / 128;
    text += static_cast<char>(bytes % 128 + (more > 0 ? 128 : 0));
    bytes = more;
  } while (bytes > 0);
  return text;
}

// Returns the packets of the messages that the input describes.
std::string packets_of(std::string_view input, bool kept) {
  std::string packets;
  while (input.size() >= 2) {
    const auto topic_bytes = static_cast<unsigned char>(input[0]),
               payload_bytes = static_cast<unsigned char>(input[1]);
    input.remove_prefix(2);
    const std::string_view topic = input.substr(0, topic_bytes);
    input.remove_prefix(topic.size());
    const std::string_view payload = input.substr(0, payload_bytes);
    input.remove_prefix(payload.size());
    packets += kept ? '\x31' : '\x30';
    packets += length_of(2 + topic.size() + payload.size());
    packets += '\0';
    packets += static_cast<char>(topic.size());
    packets += topic;
    packets += payload;
  }
  return packets;
}

// A broker on the loop: greets one client, sends it these bytes, and hears it until it goes.
class FuzzBroker {
 public:
  FuzzBroker(EventLoop& loop, std::string bytes)
      : loop_(loop),
        bytes_(std::move(bytes)),
        listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    demand(::bind(listener_.get(), any, size) == 0 && ::listen(listener_.get(), 4) == 0 &&
               ::getsockname(listener_.get(), any, &size) == 0,
           "the broker cannot listen");
    port_ = ntohs(address.sin_port);
    source_ = loop.on_ready(listener_.get(), EPOLLIN, "the broker", [this](std::uint32_t) { accept(); });
    end_after(kPatience);
  }

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] const std::string& heard() const { return heard_; }

 private:
  void accept() {
    FileDescriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!socket.valid() || client_.valid()) return;
    client_ = std::move(socket);
    client_source_ =
        loop_.on_ready(client_.get(), EPOLLIN, "the broker's client", [this](std::uint32_t) { hear(); });
  }
  void hear() {
    std::array<char, 16'384> buffer;
    const ssize_t bytes = ::read(client_.get(), buffer.data(), buffer.size());
    if (bytes <= 0) {
      client_source_->set_events(0);
      return end_after(kSettling);
    }
    heard_.append(buffer.data(), static_cast<std::size_t>(bytes));
    if (std::exchange(greeted_, true)) return say_rest();
    say(kConnected);
  }
  // The client has subscribed.
  void say_rest() {
    if (std::exchange(said_, true)) return;
    say(kSubscribed);
    say(bytes_);
    end_after(kSettling);
  }
  void end_after(std::chrono::milliseconds time) {
    end_ = loop_.at(std::chrono::steady_clock::now() + time, "the broker's end", [this] { loop_.stop(); });
  }
  void say(std::string_view bytes) { (void)::send(client_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  EventLoop& loop_;
  std::string bytes_, heard_;
  FileDescriptor listener_, client_;
  int port_ = 0;
  bool greeted_ = false, said_ = false;
  std::unique_ptr<EventLoop::IoSource> source_, client_source_;
  EventLoop::SourcePtr end_;
};

// Checks the packets that the client has sent, of which the last may be cut short.
void demand_packets(std::string_view heard, const web::HomeAssistantTopics& topics) {
  constexpr unsigned kPublish = 3, kConnect = 1, kSubscribe = 8, kPing = 12, kDisconnect = 14;
  for (bool first = true; heard.size() >= 2; first = false) {
    const unsigned kind = static_cast<unsigned char>(heard[0]) >> 4U;
    std::size_t at = 1, bytes = 0;
    for (unsigned shift = 0; at < heard.size(); shift += 7) {
      const auto digit = static_cast<unsigned char>(heard[at++]);
      bytes |= std::size_t{digit & 127U} << shift;
      if (digit < 128) break;
      demand(shift < 21, "a packet's length has more than four bytes");
    }
    if (heard.size() - at < bytes) return;
    const std::string_view content = heard.substr(at, bytes);
    heard.remove_prefix(at + bytes);
    demand(first == (kind == kConnect), "the client does not begin by connecting");
    // QoS 0 needs no acknowledgement; libmosquitto answers messages of a higher one.
    demand(kind == kConnect || kind == kPublish || kind == kSubscribe || kind == kPing ||
               kind == kDisconnect || (kind >= 4 && kind <= 7),
           "the client sends an unknown packet");
    if (kind != kPublish) continue;
    const std::size_t length = content.size() < 2
                                   ? 0
                                   : std::size_t{static_cast<unsigned char>(content[0])} * 256 +
                                         static_cast<unsigned char>(content[1]);
    const std::string_view topic = content.substr(std::min<std::size_t>(2, content.size()), length);
    demand(topic == topics.discovery || topic == topics.state || topic == topics.availability ||
               topic == topics.picture,
           "the client publishes a strange topic");
  }
}

void check(std::uint8_t shape, std::string_view input) {
  static const testing::TemporaryFolder folder;
  const std::string control = (folder.path() / "control.sock").string();
  const bool is_raw = (shape & 2U) != 0, kept = (shape & 4U) != 0;
  const web::HomeAssistantDevice device{
      .id = "contourd_1", .version = "1", .page = "", .prefix = "homeassistant"};
  EventLoop loop;
  const Log log(loop);
  const QuietLog quiet;
  const FakePrinter printer(loop, control, folder.path().string(), (shape & 1U) != 0);
  const FuzzBroker broker(loop, is_raw ? std::string(input) : packets_of(input, kept));
  {
    const web::HomeAssistantLink link(loop, log, {.host = "127.0.0.1", .port = broker.port()}, control,
                                      device);
    loop.run();
  }
  demand_packets(broker.heard(), web::HomeAssistantTopics(device));
  constexpr std::array kCommands{"pause"sv, "resume"sv, "cancel"sv, "plate_cleared"sv};
  constexpr std::array kQuestions{"watch"sv, "status"sv, "vat"sv, "mask"sv};
  int commands = 0;
  for (const std::string& method : printer.called()) {
    if (std::ranges::find(kCommands, method) != kCommands.end())
      ++commands;
    else
      demand(std::ranges::find(kQuestions, method) != kQuestions.end(), "a strange method is called");
  }
  demand(commands <= web::HomeAssistantLink::kMostCommands + 1, "too many commands are carried out");
  demand(is_raw || !kept || commands == 0, "a command that the broker has kept is carried out");
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0)
    contourd::fuzz::check(data[0], std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  return 0;
}
