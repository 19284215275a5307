// Keeps Home Assistant informed of the printer by an MQTT broker, and passes its commands on to contourd.
// Event loop's thread only.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/web/mqtt/home_assistant.hpp"
#include "daemon/web/mqtt/mqtt_client.hpp"
#include "daemon/web/printer/control_link.hpp"
#include "daemon/web/printer/mask_picture.hpp"
#include "daemon/web/printer/status_watch.hpp"

namespace contourd::web {

class HomeAssistantLink {
 public:
  // Pauses between two states, two pictures, two questions for the resin, two answers to Home Assistant's
  // start.
  static constexpr std::chrono::seconds kStatePause{1}, kPicturePause{10}, kResinPause{30}, kBirthPause{10};
  static constexpr std::size_t kMostPictureBytes = std::size_t{1} << 20U;
  // Commands that are carried out at once, and one more each second.
  static constexpr int kMostCommands = 5;

  // Connects to the broker and to contourd's control socket.
  HomeAssistantLink(EventLoop& loop, const Log& log, const MqttSettings& broker,
                    const std::filesystem::path& socket, HomeAssistantDevice device);
  // Reports the printer as offline.
  ~HomeAssistantLink();
  HomeAssistantLink(const HomeAssistantLink&) = delete;
  HomeAssistantLink& operator=(const HomeAssistantLink&) = delete;

 private:
  using Json = ControlLink::Json;
  using Time = std::chrono::steady_clock::time_point;
  // The latest messages that the broker has got over this connection.
  struct Published {
    std::optional<std::string> printer;  // the printer's name in the discovery
    std::string availability, state;
    Json layer;  // the picture's
  };
  // When the next ones may be sent or asked for.
  struct NextTimes {
    Time state{}, picture{}, resin{}, birth{}, warning{};
  };
  struct Allowance {
    double commands = kMostCommands;
    Time since{};
  };

  void tell(const Json& status);
  // Publishes what the broker does not have yet, as long as it takes it at once.
  void publish();
  [[nodiscard]] bool publish_discovery();
  [[nodiscard]] bool publish_state();
  void publish_picture();
  void ask_for_resin();
  void receive(const MqttMessage& message);
  void command(std::string_view method);
  [[nodiscard]] bool is_allowed();
  // Sends the text to a topic unless it is the latest one. Returns false if there is no room for it.
  [[nodiscard]] bool renew(std::string& latest, const std::string& topic, std::string text);

  EventLoop& loop_;
  const Log& log_;
  HomeAssistantDevice device_;
  HomeAssistantTopics topics_;
  Json status_;  // contourd's; null before the first one, or while it cannot be reached
  std::string printer_;
  HomeAssistantExtras extras_;
  Published published_;
  NextTimes next_;
  Allowance allowance_;
  ControlLink contourd_;
  MaskPicture mask_;
  StatusWatch watch_;
  MqttClient broker_;
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd::web
