// A connection to an MQTT broker (MQTT 3.1.1, QoS 0, clean sessions), kept up for as long as the object
// exists. A broker that is slow, silent, hostile or gone costs a bounded amount of memory and time: at most
// one message waits to be sent, few and short ones are received, and the pauses between attempts grow to a
// minute. Event loop's thread only; the connecting, with the resolution of the broker's name, is done by a
// thread of its own.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/web/mqtt/mqtt_settings.hpp"

struct mosquitto;

namespace contourd::web {

struct MqttMessage {
  std::string topic, payload;
};

// The properties that all connections of a client have.
struct MqttSession {
  std::string client;               // identifies this client to the broker
  MqttMessage will;                 // retained; the broker publishes it when the connection is lost
  std::vector<std::string> topics;  // to subscribe
};

struct MqttEvents {
  std::function<void()> connected;                   // the topics are subscribed
  std::function<void(const MqttMessage&)> received;  // not called for retained messages
  std::function<void()> has_room;                    // the last message is sent
};

enum class Retained { No, Yes };

class MqttClient {
 public:
  static constexpr std::chrono::seconds kKeepalive{30};
  static constexpr std::chrono::seconds kPatience{15};  // for the broker's first answer
  static constexpr std::chrono::seconds kShortestPause{1}, kLongestPause{60};
  // Longer messages are ignored, as are more than kMostMessages that arrive together.
  static constexpr std::size_t kMostPayloadBytes = 64, kMostTopicBytes = 256, kMostMessages = 16;
  // A connection that brings more than this is closed: at once, per second of its age, in all.
  static constexpr std::uint64_t kBurstBytes = 65536, kBytesPerSecond = 64, kMostBytes = 4U << 20U;

  // Connects by itself, at once and whenever the connection is lost. Logs each change of state once.
  MqttClient(EventLoop& loop, const Log& log, MqttSettings settings, MqttSession session, MqttEvents events);
  // Takes leave of the broker, which then publishes no will. Does not wait.
  ~MqttClient();
  MqttClient(const MqttClient&) = delete;
  MqttClient& operator=(const MqttClient&) = delete;

  // True if the broker is connected and nothing waits to be sent. MqttEvents::has_room is called when that
  // becomes true after a publish().
  [[nodiscard]] bool has_room() const;
  // Passes a message on; does nothing without room.
  void publish(const std::string& topic, std::string_view payload, Retained retained);
  // Passes on a message before the end, as far as the socket takes it at once. The event loop may have ended.
  void publish_last(const std::string& topic, std::string_view payload, Retained retained);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Destroy {
    void operator()(mosquitto* handle) const;
  };
  using Handle = std::unique_ptr<mosquitto, Destroy>;
  struct Attempt;
  // Reports of libmosquitto that are not handled yet.
  struct Inbox {
    std::optional<int> greeting;  // the broker's answer to the request to connect
    std::vector<MqttMessage> messages;
  };
  struct Link;

  void connect();
  [[nodiscard]] Handle make_handle();
  void take_attempt();
  void serve(std::uint32_t events);
  // Returns libmosquitto's result.
  [[nodiscard]] int pass_on(const std::string& topic, std::string_view payload, Retained retained);
  // Return a sentence's end about what is wrong; empty if nothing is.
  [[nodiscard]] std::string read();
  [[nodiscard]] std::string write();
  [[nodiscard]] std::string greet();
  void deliver();
  void tick();
  void wait_for_socket();
  void lose(const std::string& why);

  EventLoop& loop_;
  const Log& log_;
  MqttSettings settings_;
  MqttSession session_;
  MqttEvents events_;
  std::shared_ptr<Attempt> attempt_;
  std::unique_ptr<Link> link_;
  EventLoop::SourcePtr attempt_source_, timer_;
  std::chrono::seconds pause_ = kShortestPause;
  std::string trouble_;  // as logged; empty after a connection
};

}  // namespace contourd::web
