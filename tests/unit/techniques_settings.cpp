#include <gtest/gtest.h>

#include <set>

#include "core/errors.h"
#include "techniques/light_stage.h"
#include "techniques/technique.h"

namespace halflight {
namespace {

/// The message of the Error that `action` throws; its exit code must be `usage`.
template <class Action>
std::string usage_message(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  ADD_FAILURE() << "threw nothing";
  return "";
}

TEST(Settings, HaveTheirDefaultsUntilSet) {
  SettingValues values;
  EXPECT_EQ(values.get("lights.count"), 32768);
  EXPECT_EQ(values.get("bidirectional.brdf-samples"), 64);
  values.set("lights.count", "1e6");
  EXPECT_EQ(values.get("lights.count"), 1e6);
  values.set("bidirectional.form", "printed");
  EXPECT_EQ(values.get("bidirectional.form"), 1);
  EXPECT_EQ(values.changed().size(), 2u);
  values.set("lights.count", "32768");
  values.set("bidirectional.form", "repaired");
  EXPECT_EQ(values, SettingValues());
}

TEST(Settings, RefuseWhatIsUnknownOrOutOfBounds) {
  SettingValues values;
  EXPECT_NE(usage_message([&] { values.set("light.count", "3"); }).find("did you mean 'lights.count'"),
            std::string::npos);
  EXPECT_NE(usage_message([&] { values.set("bidirectional.form", "printd"); }).find("printed"),
            std::string::npos);
  for (const char* bad : {"0", "1000001", "-1", "nan", "inf", "12x", "", " 5", "1e999"})
    EXPECT_NE(usage_message([&] { values.set("lights.count", bad); }).find("lights.count"), std::string::npos)
        << bad;
  EXPECT_EQ(values, SettingValues());
}

TEST(Settings, KeysAreUniqueAndDefaultsWithinBounds) {
  std::set<std::string_view> keys;
  for (const SettingInfo* info : all_settings()) {
    EXPECT_TRUE(keys.insert(info->key).second) << info->key;
    EXPECT_LE(info->low, info->value);
    EXPECT_LE(info->value, info->high);
    EXPECT_FALSE(info->help.empty());
    if (!info->choices.empty()) {
      EXPECT_EQ(info->high, info->choices.size() - 1);
    }
  }
}

TEST(Settings, CutSettingsFollow) {
  SettingValues values;
  values.set("cut.error", "0.1"), values.set("cut.sigma", "5"), values.set("cut.least", "300"),
      values.set("cut.most", "200");
  const CutSettings cut = cut_settings(values);
  EXPECT_FLOAT_EQ(cut.relative_error, 0.1f);
  EXPECT_EQ(cut.sigma, 5);
  EXPECT_EQ(cut.least, 300u);
  EXPECT_EQ(cut.most, 300u);
}

TEST(Techniques, AreFoundByTheirIds) {
  std::set<std::string_view> ids;
  for (const TechniqueInfo& info : techniques()) {
    EXPECT_TRUE(ids.insert(info.id).second);
    EXPECT_EQ(find_technique(info.id).id, info.id);
    EXPECT_FALSE(info.title.empty() || info.source.empty());
    EXPECT_NE(info.make(), nullptr);
  }
  for (const char* id : {"reference", "illumination", "bidirectional", "path"})
    EXPECT_TRUE(ids.count(id)) << id;
  EXPECT_NE(usage_message([] { find_technique("bidirectionl"); }).find("did you mean 'bidirectional'"),
            std::string::npos);
}

TEST(Techniques, RunInTheTargetsTheySupport) {
  EXPECT_EQ(choose_target(find_technique("bidirectional"), std::nullopt), Target::discrete);
  EXPECT_EQ(choose_target(find_technique("bidirectional"), Target::continuous), Target::continuous);
  EXPECT_EQ(choose_target(find_technique("reference"), std::nullopt), Target::discrete);
  EXPECT_EQ(choose_target(find_technique("path"), std::nullopt), Target::continuous);
  EXPECT_NE(usage_message([] { choose_target(find_technique("path"), Target::discrete); }).find("discrete"),
            std::string::npos);
  EXPECT_NE(usage_message([] {
              choose_target(find_technique("reference"), Target::continuous);
            }).find("continuous"),
            std::string::npos);
}

}  // namespace
}  // namespace halflight
