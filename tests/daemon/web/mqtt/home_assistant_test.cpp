#include "daemon/web/mqtt/home_assistant.hpp"

#include <algorithm>
#include <set>
#include <string>

#include "tests/catch.hpp"

using namespace contourd::web;

namespace {

using Json = nlohmann::ordered_json;

const HomeAssistantDevice kDevice{
    .id = "contourd_1", .version = "1.2", .page = "http://192.168.1.20:8080/", .prefix = "homeassistant"};

Json idle() {
  return {{"printer", "Attic"},
          {"state", "idle"},
          {"job", nullptr},
          {"queued", 0},
          {"plate", "clear"},
          {"held", nullptr},
          {"not_ready_reason", nullptr},
          {"interrupted", nullptr},
          {"waiting_for", nullptr},
          {"last", nullptr}};
}

Json printing() {
  Json status = idle();
  status["state"] = "exposing";
  status["plate"] = "occupied";
  status["job"] = {{"name", "gear"},   {"layer", 7},           {"layers", 30},
                   {"layers_done", 5}, {"time_left_s", 754.9}, {"interruption", nullptr}};
  return status;
}

}  // namespace

TEST_CASE("a printer is one device of Home Assistant with a page of its own") {
  const Json found = discovery_of(kDevice, "Attic");
  CHECK(found["dev"]["ids"] == Json({"contourd_1"}));
  CHECK(found["dev"]["name"] == "Attic");
  CHECK(found["dev"]["sw"] == "1.2");
  CHECK(found["dev"]["cu"] == "http://192.168.1.20:8080/");
  CHECK(found["o"]["name"] == "contourd");
  HomeAssistantDevice alone = kDevice;
  alone.page.clear();
  CHECK_FALSE(discovery_of(alone, "Attic")["dev"].contains("cu"));
}

TEST_CASE("each component of the discovery has a platform, a name and an identifier of its own") {
  std::set<std::string> identifiers;
  const Json found = discovery_of(kDevice, "Attic");
  for (const auto& [key, component] : found["cmps"].items()) {
    INFO(key);
    CHECK_FALSE(component["p"].get<std::string>().empty());
    CHECK_FALSE(component["name"].get<std::string>().empty());
    CHECK(identifiers.insert(component["unique_id"].get<std::string>()).second);
  }
  CHECK(identifiers.size() == 14);
}

TEST_CASE("the discovery names the topics that the printer uses") {
  const HomeAssistantTopics topics(kDevice);
  const Json found = discovery_of(kDevice, "Attic");
  CHECK(topics.discovery == "homeassistant/device/contourd_1/config");
  CHECK(topics.birth == "homeassistant/status");
  CHECK(found["stat_t"] == topics.state);
  CHECK(found["avty_t"] == topics.availability);
  CHECK(found["cmps"]["mask"]["image_topic"] == topics.picture);
  for (const char* method : {"pause", "resume", "cancel", "plate_cleared"})
    CHECK(method_of(topics, found["cmps"][method]["command_topic"].get<std::string>()) == method);
}

TEST_CASE("topics other than those of the buttons name no method") {
  const HomeAssistantTopics topics(kDevice);
  for (const char* topic : {"", "contourd/contourd_1/command/", "contourd/contourd_1/command/home",
                            "contourd/contourd_1/command/pause/x", "contourd/contourd_2/command/pause",
                            "contourd/contourd_1/state", "pause", "homeassistant/status"})
    CHECK(method_of(topics, topic).empty());
}

TEST_CASE("the printer's name is made safe to show") {
  CHECK(discovery_of(kDevice, "At\ntic\x1b[1m")["dev"]["name"] == "At?tic?[1m");
}

TEST_CASE("an idle printer has no progress and no problem") {
  const Json state = state_of(idle(), {});
  CHECK(state["state"] == "idle");
  for (const char* key :
       {"job", "progress", "layer", "layers", "time_left_s", "resin_ml", "why", "outcome", "refused"})
    CHECK(state[key].is_null());
  CHECK(state["problem"] == "OFF");
  CHECK(state["plate"] == "OFF");
}

TEST_CASE("a print has progress, layers and a rounded time left") {
  const Json state = state_of(printing(), {.resin_ml = 149.96, .refused = {}});
  CHECK(state["state"] == "printing");
  CHECK(state["job"] == "gear");
  CHECK(state["progress"] == 16.7);
  CHECK(state["layer"] == 7);
  CHECK(state["layers"] == 30);
  CHECK(state["time_left_s"] == 750);
  CHECK(state["resin_ml"] == 150.0);
  CHECK(state["plate"] == "ON");
}

TEST_CASE("every state of contourd belongs to one of the states that the discovery lists") {
  const Json options = discovery_of(kDevice, "Attic")["cmps"]["state"]["options"];
  const auto listed = [&options](const std::string& state) {
    Json status = printing();
    status["state"] = state;
    const Json shown = state_of(status, {})["state"];
    CHECK(std::find(options.begin(), options.end(), shown) != options.end());
    return shown.get<std::string>();
  };
  CHECK(listed("idle") == "idle");
  CHECK(listed("warming up") == "preparing");
  CHECK(listed("rising") == "printing");
  CHECK(listed("held") == "paused");
  CHECK(listed("parking") == "finishing");
  CHECK(listed("a state of a later version") == "printing");
}

TEST_CASE("whatever needs the owner is a problem with its reason") {
  const auto why = [](const char* key, const Json& value) {
    Json status = idle();
    status[key] = value;
    const Json state = state_of(status, {});
    CHECK(state["problem"] == "ON");
    return state["why"].get<std::string>();
  };
  CHECK(why("held", "the queue waits: contourctl plate-cleared") ==
        "the queue waits: contourctl plate-cleared");
  CHECK(why("not_ready_reason", "the lid is open") == "the lid is open");
  CHECK(why("interrupted", {{"job", "gear"}}) == "the print of gear was interrupted");
  Json status = printing();
  status["job"]["interruption"] = "the lid was opened";
  CHECK(state_of(status, {})["why"] == "the lid was opened");
}

TEST_CASE("the last print's outcome and the last refusal are part of the state") {
  Json status = idle();
  status["last"] = {{"job", "gear"}, {"outcome", "failed"}, {"reason", "the film tore"}};
  const Json state = state_of(status, {.resin_ml = {}, .refused = "there is no print to pause"});
  CHECK(state["outcome"] == "failed");
  CHECK(state["last_job"] == "gear");
  CHECK(state["outcome_reason"] == "the film tore");
  CHECK(state["refused"] == "there is no print to pause");
}

TEST_CASE("a status with fields that are missing or of other types makes a state all the same") {
  for (const char* text :
       {"{}", R"({"state": 7, "job": [], "last": "x", "plate": null})",
        R"({"job": {"layers": 0, "layers_done": 0, "layer": "x", "time_left_s": null}})"}) {
    const Json state = state_of(Json::parse(text), {});
    CHECK(state["progress"].is_null());
    CHECK(state["problem"] == "OFF");
  }
}
