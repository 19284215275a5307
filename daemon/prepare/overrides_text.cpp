#include "daemon/prepare/overrides_text.hpp"

#include "daemon/json/config_error.hpp"

namespace contourd {

std::string describe(const OverriddenSettings& overridden) {
  std::string text;
  for (const OverriddenSetting& each : overridden) {
    text += text.empty() ? "" : ", ";
    text += std::string(each.setting) + " " + decimal(each.asked) + " instead of " + decimal(each.profile);
  }
  return text;
}

nlohmann::ordered_json overrides_json(const OverriddenSettings& overridden) {
  auto list = nlohmann::ordered_json::array();
  for (const OverriddenSetting& each : overridden)
    list.push_back({{"setting", each.setting}, {"asked", each.asked}, {"profile", each.profile}});
  return list;
}

}  // namespace contourd
