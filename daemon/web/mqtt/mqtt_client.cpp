#include "daemon/web/mqtt/mqtt_client.hpp"

// <netinet/tcp.h> lacks the number of bytes received.
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/tcp.h>
#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include "daemon/system/readable.hpp"
#include "hw/event_descriptor.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd::web {
namespace {

constexpr std::string_view kClientName = "the connection to the MQTT broker";
constexpr std::chrono::seconds kTick{5};
// A connection that has lasted this long makes the pauses short again.
constexpr std::chrono::seconds kLasting{60};
constexpr int kMostPackets = 50;       // read at once
constexpr int kReceiveBuffer = 16384;  // in the kernel, so that a flood is noticed early

// Returns a clause about an error of libmosquitto. `error` is errno.
std::string reason_of(int result, int error) {
  switch (result) {
    case MOSQ_ERR_ERRNO:
      return std::strerror(error);
    case MOSQ_ERR_EAI:
      return "its name is not known";
    case MOSQ_ERR_CONN_LOST:
      return "it has closed the connection";
    case MOSQ_ERR_KEEPALIVE:
      return "it does not answer";
    case MOSQ_ERR_TLS:
      return "the TLS handshake failed: check its certificate and the file given by --ca";
    default:
      return mosquitto_strerror(result);
  }
}

}  // namespace

// An attempt to connect. The thread that makes it owns it as well, so it may outlive the client.
struct MqttClient::Attempt {
  Handle handle;
  EventDescriptor over;
  int result = MOSQ_ERR_SUCCESS, error = 0;
};

// A connection.
struct MqttClient::Link {
  Handle handle{};
  FileDescriptor socket{};  // a duplicate, since libmosquitto closes its own whenever a call fails
  std::unique_ptr<EventLoop::IoSource> source{};
  Inbox inbox{};
  Time since{};
  bool is_greeted = false;
  std::string trouble{};  // an error of publish()

  // True if the broker has sent more than a client like this can get.
  [[nodiscard]] bool is_flooded() const {
    tcp_info info{};
    socklen_t size = sizeof info;
    if (::getsockopt(socket.get(), IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return false;
    const auto age =
        std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - since);
    const auto allowed = kBurstBytes + kBytesPerSecond * static_cast<std::uint64_t>(age.count());
    return info.tcpi_bytes_received > std::min(allowed, kMostBytes);
  }
};

void MqttClient::Destroy::operator()(mosquitto* handle) const {
  mosquitto_destroy(handle);
}

MqttClient::MqttClient(EventLoop& loop, const Log& log, MqttSettings settings, MqttSession session,
                       MqttEvents events)
    : loop_(loop),
      log_(log),
      settings_(std::move(settings)),
      session_(std::move(session)),
      events_(std::move(events)) {
  mosquitto_lib_init();
  connect();
}

MqttClient::~MqttClient() {
  if (link_ && link_->is_greeted) mosquitto_disconnect(link_->handle.get());
}

MqttClient::Handle MqttClient::make_handle() {
  Handle handle(mosquitto_new(session_.client.c_str(), true, nullptr));
  if (!handle) throw std::system_error(errno, std::generic_category(), "mosquitto_new");
  const auto check = [](int result, const char* what) {
    if (result != MOSQ_ERR_SUCCESS)
      throw std::system_error(result == MOSQ_ERR_ERRNO ? errno : EINVAL, std::generic_category(), what);
  };
  const MqttMessage& will = session_.will;
  check(mosquitto_will_set(handle.get(), will.topic.c_str(), static_cast<int>(will.payload.size()),
                           will.payload.data(), 0, true),
        "the last will");
  if (!settings_.user.empty())
    check(mosquitto_username_pw_set(handle.get(), settings_.user.c_str(), settings_.password.c_str()),
          "the user of the MQTT broker");
  if (!settings_.ca_file.empty())
    check(mosquitto_tls_set(handle.get(), settings_.ca_file.c_str(), nullptr, nullptr, nullptr, nullptr),
          settings_.ca_file.c_str());
  mosquitto_connect_callback_set(handle.get(), [](mosquitto*, void* inbox, int greeting) {
    static_cast<Inbox*>(inbox)->greeting = greeting;
  });
  mosquitto_message_callback_set(handle.get(), [](mosquitto*, void* inbox, const mosquitto_message* message) {
    std::vector<MqttMessage>& messages = static_cast<Inbox*>(inbox)->messages;
    const auto bytes = static_cast<std::size_t>(message->payloadlen);
    if (message->retain || messages.size() >= kMostMessages || bytes > kMostPayloadBytes ||
        std::strlen(message->topic) > kMostTopicBytes)
      return;
    messages.push_back({message->topic, std::string(static_cast<const char*>(message->payload), bytes)});
  });
  return handle;
}

void MqttClient::connect() {
  try {
    const auto attempt = std::make_shared<Attempt>();
    attempt->handle = make_handle();
    attempt_source_ = loop_.on_ready(attempt->over.descriptor(), EPOLLIN, kClientName,
                                     [this](std::uint32_t) { take_attempt(); });
    // Connecting blocks: for the name, for up to two minutes for an address that does not answer.
    std::thread([attempt, host = settings_.host, port = settings_.port] {
      (void)::pthread_setname_np(::pthread_self(), "mqtt-connect");
      attempt->result =
          mosquitto_connect(attempt->handle.get(), host.c_str(), port, static_cast<int>(kKeepalive.count()));
      attempt->error = errno;
      attempt->over.signal();
    }).detach();
    attempt_ = attempt;
  } catch (const std::system_error& error) {
    attempt_source_.reset();
    lose(printable(error.what()));
  }
}

void MqttClient::take_attempt() {
  const std::shared_ptr<Attempt> attempt = std::move(attempt_);
  attempt_source_.reset();
  if (attempt->result != MOSQ_ERR_SUCCESS) return lose(reason_of(attempt->result, attempt->error));
  link_ = std::make_unique<Link>();
  link_->handle = std::move(attempt->handle);
  link_->socket = FileDescriptor(::fcntl(mosquitto_socket(link_->handle.get()), F_DUPFD_CLOEXEC, 0));
  if (!link_->socket.valid()) return lose(std::strerror(errno));
  mosquitto_user_data_set(link_->handle.get(), &link_->inbox);
  (void)::setsockopt(link_->socket.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  link_->since = std::chrono::steady_clock::now();
  link_->source = loop_.on_ready(link_->socket.get(), EPOLLIN, kClientName,
                                 [this](std::uint32_t events) { serve(events); });
  tick();
}

bool MqttClient::has_room() const {
  return link_ && link_->is_greeted && link_->trouble.empty() && !mosquitto_want_write(link_->handle.get());
}

void MqttClient::publish(const std::string& topic, std::string_view payload, Retained retained) {
  if (!has_room()) return;
  const int result = pass_on(topic, payload, retained);
  if (result == MOSQ_ERR_SUCCESS) return wait_for_socket();
  // The caller may not expect to be told of the loss now.
  link_->trouble = reason_of(result, errno);
  timer_ = loop_.at(std::chrono::steady_clock::now(), kClientName, [this] { tick(); });
}

void MqttClient::publish_last(const std::string& topic, std::string_view payload, Retained retained) {
  if (has_room()) (void)pass_on(topic, payload, retained);
}

int MqttClient::pass_on(const std::string& topic, std::string_view payload, Retained retained) {
  return mosquitto_publish(link_->handle.get(), nullptr, topic.c_str(), static_cast<int>(payload.size()),
                           payload.data(), 0, retained == Retained::Yes);
}

void MqttClient::serve(std::uint32_t events) {
  std::string trouble;
  const bool had_room = has_room();
  if ((events & EPOLLOUT) != 0) trouble = write();
  if (trouble.empty() && (events & ~static_cast<std::uint32_t>(EPOLLOUT)) != 0) trouble = read();
  if (trouble.empty()) trouble = greet();
  if (!trouble.empty()) return lose(trouble);
  deliver();
  wait_for_socket();
  if (!had_room && has_room()) events_.has_room();
}

std::string MqttClient::read() {
  for (int packet = 0; packet < kMostPackets; ++packet) {
    if (link_->is_flooded()) return "it sends more than this client can have asked for";
    errno = 0;
    const int result = mosquitto_loop_read(link_->handle.get(), 1);
    const int error = errno;
    if (link_->inbox.greeting.value_or(0) != 0) return greet();
    if (result != MOSQ_ERR_SUCCESS) return reason_of(result, error);
    if (error == EAGAIN) break;
  }
  // After the handshake of TLS, the first packet waits; and an answer may.
  return write();
}

std::string MqttClient::write() {
  if (!mosquitto_want_write(link_->handle.get())) return "";
  const int result = mosquitto_loop_write(link_->handle.get(), 1);
  return result == MOSQ_ERR_SUCCESS ? "" : reason_of(result, errno);
}

std::string MqttClient::greet() {
  const std::optional<int> greeting = std::exchange(link_->inbox.greeting, std::nullopt);
  if (!greeting) return "";
  if (*greeting == CONNACK_REFUSED_BAD_USERNAME_PASSWORD || *greeting == CONNACK_REFUSED_NOT_AUTHORIZED)
    return "it refuses the user or the password: set them by sudo contourctl web mqtt";
  if (*greeting != 0) return fmt::format("it refuses the connection (code {})", *greeting);
  for (const std::string& topic : session_.topics) {
    const int result = mosquitto_subscribe(link_->handle.get(), nullptr, topic.c_str(), 0);
    if (result != MOSQ_ERR_SUCCESS) return reason_of(result, errno);
  }
  if (!std::exchange(link_->is_greeted, true)) {
    log_.info("mqtt", fmt::format("connected to the MQTT broker {}", broker_of(settings_)));
    trouble_.clear();
    events_.connected();
  }
  return "";
}

void MqttClient::deliver() {
  for (const MqttMessage& message : std::exchange(link_->inbox.messages, {}))
    events_.received(message);
}

void MqttClient::tick() {
  timer_ = loop_.at(std::chrono::steady_clock::now() + kTick, kClientName, [this] { tick(); });
  if (!link_->trouble.empty()) return lose(std::string(link_->trouble));
  const int result = mosquitto_loop_misc(link_->handle.get());
  if (result != MOSQ_ERR_SUCCESS) return lose(reason_of(result, errno));
  if (!link_->is_greeted && std::chrono::steady_clock::now() - link_->since > kPatience)
    return lose("it does not answer");
  // TLS may have kept a part of a message that the socket no longer shows.
  constexpr std::uint32_t kNone = 0, kRead = EPOLLIN;
  serve(settings_.ca_file.empty() ? kNone : kRead);
}

void MqttClient::wait_for_socket() {
  // Before the greeting, the socket is writable while TLS waits for the broker.
  const bool writes = link_->is_greeted && mosquitto_want_write(link_->handle.get());
  link_->source->set_events(writes ? EPOLLIN | EPOLLOUT : EPOLLIN);
}

void MqttClient::lose(const std::string& why) {
  const bool was_connected = link_ && link_->is_greeted;
  const auto now = std::chrono::steady_clock::now();
  if (was_connected && now - link_->since > kLasting) pause_ = kShortestPause;
  link_.reset();
  if (was_connected || why != trouble_)
    log_.warning("mqtt",
                 fmt::format("{} the MQTT broker {}: {}; contourd-web keeps trying",
                             was_connected ? "lost" : "cannot connect to", broker_of(settings_), why));
  trouble_ = why;
  timer_ = loop_.at(now + pause_, kClientName, [this] { connect(); });
  pause_ = std::min(pause_ * 2, kLongestPause);
}

}  // namespace contourd::web
