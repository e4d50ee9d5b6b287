#pragma once

#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/scenario_app.h>

namespace tenon::apps {

/// Empty keys, for a customisation that has no keys.
struct NoKeys {
  static FieldList Fields() { return {}; }
};

/// The blocks of a run: those of the user's program, or the shipped ones to compare with.
enum class Blocks { kMine, kShipped };
/// Name of the customised variant in a comparison, and of a user's block in figures.
inline constexpr const char* kMine = EnumName(Blocks::kMine);

/// The map `custom` of a scenario: the keys of a customisation, and `blocks`.
template <class Keys>
struct CustomKeys : Keys {
  Blocks blocks = Blocks::kMine;
  static FieldList Fields() { return Keys::Fields() + FieldList{{"blocks", &CustomKeys::blocks}}; }
};

/// Throws KeyError if a scenario has the key `custom`, whose contents are known only to another program.
void RefuseCustomKeys(const std::optional<YamlText>& custom);
/// Replaces the key `custom` in a list of keys by the keys of a customisation.
std::vector<ScenarioKey> WithCustomKeys(std::vector<ScenarioKey> keys, std::vector<ScenarioKey> own);

/// Says a text on stderr, once in a program.
void SayOnce(const std::string& text);
/// Returns whether the block that stands in the place of `block` has parameters of type P, from which its
/// limits are known. If not, says once that they are not judged.
template <class P>
bool KnowsLimits(const System& block) {
  const bool known = dynamic_cast<const LeafSystem<P>*>(CurrentBlock(block)) != nullptr;
  if (!known)
    SayOnce("note: the limits of your block '" + block.path() +
            "' are unknown and not judged, because its parameters have another type than the shipped ones\n");
  return known;
}

/// All blocks of a diagram.
std::vector<const System*> BlocksOf(const Subdiagram& diagram);
/// Says on stderr, once in a program, which inputs of `shipped` blocks were connected and are missing in the
/// blocks that replaced them.
void SayDropped(const std::vector<const System*>& shipped);

/// A change that a user's program makes to the diagram of an app before each run, with keys of its own in the
/// scenario's map `custom`. Empty in the shipped apps. Runs of a campaign call it in several threads at once.
template <class Diagram>
class Customisation {
 public:
  Customisation() = default;

  /// Function that changes the diagram, see Customisable::Customise.
  template <HasFields Keys, class Hook>
  static Customisation Of(Hook hook) {
    Customisation made;
    using Read = CustomKeys<Keys>;
    made.read_ = [](const YamlDocument& scenario) { return WriteYaml(scenario.ReadAt<Read>("custom")); };
    made.keys_ = [] { return KeysOf<Read>(); };
    made.apply_ = [hook = std::move(hook)](DiagramBuilder& builder, Diagram& diagram,
                                           const YamlDocument& written, Outputs& outputs) {
      const auto keys = written.Read<Read>();
      if (keys.blocks == Blocks::kShipped) return;
      if constexpr (std::is_invocable_v<Hook, DiagramBuilder&, Diagram&, const Keys&, Outputs&>) {
        hook(builder, diagram, keys, outputs);
      } else if constexpr (std::is_invocable_v<Hook, DiagramBuilder&, Diagram&, const Keys&>) {
        hook(builder, diagram, keys);
      } else if constexpr (std::is_invocable_v<Hook, DiagramBuilder&, Diagram&, Outputs&>) {
        hook(builder, diagram, outputs);
      } else {
        static_assert(std::is_invocable_v<Hook, DiagramBuilder&, Diagram&>,
                      "Customise: write a function of (DiagramBuilder&, the app's diagram&, const Keys&, "
                      "Outputs&); the last two are optional.");
        hook(builder, diagram);
      }
    };
    return made;
  }

  explicit operator bool() const { return apply_ != nullptr; }

  /// Reads the map `custom` of a scenario, checks it, and stores it with every default filled in. Throws
  /// ParameterError with the place of an invalid key, and KeyError if there are such keys but no
  /// customisation.
  void Read(const YamlDocument& scenario, std::optional<YamlText>& custom) const {
    if (!*this) return RefuseCustomKeys(custom);
    custom = YamlText{YamlDocument::Parse(read_(scenario), "custom").Flow()};
  }

  /// Reads a scenario with its map `custom`, see Read.
  template <class Scenario>
  Scenario ReadScenario(const YamlDocument& document) const {
    auto scenario = document.Read<Scenario>();
    Read(document, scenario.custom);
    return scenario;
  }

  /// Applies the change with keys that Read has stored, unless these choose the shipped blocks, and says
  /// which connections the new blocks have dropped. Throws KeyError of `custom` for errors of the change.
  void Apply(DiagramBuilder& builder, Diagram& diagram, const std::optional<YamlText>& custom,
             Outputs& outputs) const {
    if (!*this) return;
    const std::vector<const System*> shipped = BlocksOf(diagram);
    Blame("custom", [&] {
      apply_(builder, diagram, YamlDocument::Parse(custom ? custom->text : "{}", "custom"), outputs);
    });
    SayDropped(shipped);
  }

  /// Lists the keys of a scenario: those of the app, and those of the customisation as `custom.KEY`.
  std::vector<ScenarioKey> Keys(std::vector<ScenarioKey> keys) const {
    return *this ? WithCustomKeys(std::move(keys), keys_()) : keys;
  }

 private:
  std::function<std::string(const YamlDocument& scenario)> read_;
  std::function<std::vector<ScenarioKey>()> keys_;
  std::function<void(DiagramBuilder&, Diagram&, const YamlDocument& written, Outputs&)> apply_;
};

/// Returns whether a customisation has replaced a block.
inline bool IsReplaced(const System& block) {
  return CurrentBlock(block) != &block;
}

/// Base of the apps whose diagram a program can change. With a change, `--compare` also runs the variant
/// `mine` with the change; the shipped variants run without it.
template <class App, class Diagram>
class Customisable {
 public:
  /// Changes the diagram of each run by `hook(builder, diagram, keys, outputs)`, whose last two arguments are
  /// optional. The hook is called before the diagram is built and before faults are inserted. `Keys` is a
  /// struct with Fields() and describes the map `custom` of the scenario, which is read, checked and listed
  /// by --keys like all other keys:
  ///
  ///     struct Keys {
  ///       double gain_per_s = 30;
  ///       static tenon::FieldList Fields() { return {{"gain_per_s", &Keys::gain_per_s}}; }
  ///     };
  ///     app.Customise<Keys>([](DiagramBuilder& builder, QuadrupedWalk& walk, const Keys& keys) {
  ///       builder.Replace<MyObserver>(walk.observer, {.gain = keys.gain_per_s});
  ///     });
  template <HasFields Keys = NoKeys, class Hook>
  App& Customise(Hook hook) {
    customisation_ = Customisation<Diagram>::template Of<Keys>(std::move(hook));
    return static_cast<App&>(*this);
  }

 protected:
  /// Makes an app, see MakeScenarioApp, of functions whose last argument is the customisation.
  ScenarioApp MakeApp(const char* name, const char* description, std::vector<ScenarioFile> files, auto read,
                      auto check, auto run) const {
    using Scenario = decltype(read(std::declval<const YamlDocument&>(), customisation_));
    const auto customised = [own = customisation_](auto call) {
      return [own, call](const auto&... arguments) { return call(arguments..., own); };
    };
    ScenarioApp app =
        MakeScenarioApp(name, description, customised(read), customised(check), customised(run));
    app.keys = [own = customisation_] { return own.Keys(KeysOf<Scenario>()); };
    app.files = std::move(files);
    app.figures = "thesis";
    return app;
  }

  Customisation<Diagram> customisation_;
};

}  // namespace tenon::apps
