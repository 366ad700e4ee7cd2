// The statement loop: reads lines, replaces constants, hands each statement to its handler, collects faults,
// and follows includes. What the statements mean is in settings.cpp, material_statement.cpp and
// shape_statements.cpp.
#include <new>
#include <utility>

#include "scene/limits.hpp"
#include "scene/parse.hpp"
#include "scene/parser_state.hpp"
#include "scene/precision.hpp"

namespace mlt {
namespace {

class SceneParser {
 public:
  explicit SceneParser(SourceFolder folder) { state_.folder = std::move(folder); }

  void parse_file(const SourceFile& file);
  /// Throws InputError if there was any fault.
  SceneDescription finish(const std::string& path);

  SourceFolder& folder() { return state_.folder; }

 private:
  void parse_statement(const SourceFile& file, const LineReader& lines, const std::vector<Token>& raw);
  void expand(const LineReader& lines, const std::vector<Token>& raw, std::vector<Token>& tokens) const;
  void dispatch(const SourceFile& file, StatementKind kind, StatementCursor& cursor,
                const std::vector<Token>& tokens);
  void parse_include(const SourceFile& file, StatementCursor& cursor);
  void parse_define(StatementCursor& cursor, const std::vector<Token>& tokens);
  bool skipped(StatementKind kind);

  struct Word {
    std::string text;
    bool quoted = false;
  };

  ParserState state_;
  std::map<std::string, std::vector<Word>, std::less<>> constants_;
  std::vector<std::string> open_files_;  ///< real paths, the scene file first
};

void SceneParser::parse_file(const SourceFile& file) {
  open_files_.push_back(file.real_path);
  LineReader lines(file.text(), file.shown_path);
  std::vector<Token> raw;
  while (!state_.diagnostics.full()) {
    try {
      if (!lines.next(raw)) break;
      parse_statement(file, lines, raw);
    } catch (const InputError& error) {
      state_.diagnostics.absorb(error);
    }
  }
  open_files_.pop_back();
}

/// Replaces each unquoted $NAME by the constant's words; they get the place of the $NAME.
void SceneParser::expand(const LineReader& lines, const std::vector<Token>& raw,
                         std::vector<Token>& tokens) const {
  for (const Token& token : raw) {
    if (token.quoted || token.text.empty() || token.text[0] != '$') {
      tokens.push_back(token);
    } else {
      const SourceLocation at{lines.file(), lines.line(), token.column};
      const std::string_view name = token.text.substr(1);
      const auto constant = constants_.find(name);
      if (constant == constants_.end()) {
        std::vector<std::string> known;
        for (const auto& [known_name, words] : constants_) known.push_back(known_name);
        fail_at(at, "no constant " + printable(name) + " is defined before this line" +
                        allowed_words(name, known));
      }
      for (const Word& word : constant->second) tokens.push_back(Token{word.text, token.column, word.quoted});
    }
    if (tokens.size() > kMaxStatementTokens) {
      fail_at(SourceLocation{lines.file(), lines.line(), token.column},
              "the statement has more than " + std::to_string(kMaxStatementTokens) +
                  " words after its constants are replaced, which is the limit");
    }
  }
}

void SceneParser::parse_statement(const SourceFile& file, const LineReader& lines,
                                  const std::vector<Token>& raw) {
  std::vector<Token> tokens;
  expand(lines, raw, tokens);
  const std::string& name = lines.file();
  StatementCursor first(name, lines.line(), tokens, lines.end_column(), "");
  const std::size_t index = first.keyword(kStatements, "a statement");
  StatementCursor cursor(name, lines.line(), tokens, lines.end_column(), kStatements[index].form);
  cursor.word("a statement");
  const auto kind = static_cast<StatementKind>(index);
  if (!skipped(kind)) dispatch(file, kind, cursor, tokens);
}

/// Between inline_mesh and end only vertex, face and end stand. When the inline_mesh line itself was faulty,
/// its lines are passed over, so that one fault gives one message.
bool SceneParser::skipped(StatementKind kind) {
  if (!state_.faulty_mesh) return false;
  const bool inner =
      kind == StatementKind::vertex || kind == StatementKind::face || kind == StatementKind::end;
  if (kind == StatementKind::end || !inner) state_.faulty_mesh = false;
  return inner;
}

void SceneParser::dispatch(const SourceFile& file, StatementKind kind, StatementCursor& cursor,
                           const std::vector<Token>& tokens) {
  const bool inner =
      kind == StatementKind::vertex || kind == StatementKind::face || kind == StatementKind::end;
  if (state_.open_mesh && !inner) {
    const SourceLocation& opened = state_.open_mesh->clauses.attributes.location;
    const std::string text = "the inline_mesh of line " + std::to_string(opened.line) +
                             " is still open; vertex, face or end is expected";
    // Taken as closed from here on, so that one missing end gives one message.
    state_.open_mesh.reset();
    fail_at(cursor.start(), text);
  }
  switch (kind) {
    case StatementKind::include:
      return parse_include(file, cursor);
    case StatementKind::define:
      return parse_define(cursor, tokens);
    case StatementKind::film:
      return parse_film(state_, cursor);
    case StatementKind::depth:
      return parse_depth(state_, cursor);
    case StatementKind::camera:
      return parse_camera(state_, cursor);
    case StatementKind::material:
      return parse_material(state_, cursor);
    case StatementKind::triangle:
      return parse_triangle(state_, cursor);
    case StatementKind::quad:
      return parse_quad(state_, cursor);
    case StatementKind::box:
      return parse_box(state_, cursor);
    case StatementKind::sphere:
      return parse_sphere(state_, cursor);
    case StatementKind::mesh:
      return parse_mesh(state_, cursor, file.relative_path);
    case StatementKind::inline_mesh:
      return parse_inline_mesh(state_, cursor);
    case StatementKind::vertex:
      return parse_vertex(state_, cursor);
    case StatementKind::face:
      return parse_face(state_, cursor);
    case StatementKind::end:
      return parse_end(state_, cursor);
  }
}

void SceneParser::parse_include(const SourceFile& file, StatementCursor& cursor) {
  const std::string name(cursor.word("the name of a scene file"));
  const SourceLocation at = cursor.last();
  cursor.expect_end();
  const SourceFile included = state_.folder.read(name, file.relative_path, kMaxSceneFileBytes, at);
  for (const std::string& open : open_files_) {
    if (open == included.real_path)
      fail_at(at, printable(name) + " includes itself, directly or through others");
  }
  if (open_files_.size() >= kMaxIncludeDepth) {
    fail_at(at, "includes are nested more than " + std::to_string(kMaxIncludeDepth) +
                    " deep, which is the limit");
  }
  // Recursion bounded by kMaxIncludeDepth.
  parse_file(included);
}

void SceneParser::parse_define(StatementCursor& cursor, const std::vector<Token>& tokens) {
  const std::string name = cursor.name("the constant's name");
  if (constants_.find(name) != constants_.end()) {
    fail_at(cursor.last(), "the constant " + printable(name) + " is already defined; choose another name");
  }
  if (constants_.size() >= kMaxConstants) {
    fail_at(cursor.start(), "more than " + std::to_string(kMaxConstants) + " constants, which is the limit");
  }
  cursor.word("the constant's value");
  std::vector<Word>& words = constants_[name];
  for (std::size_t i = 2; i < tokens.size(); ++i) {
    words.push_back(Word{std::string(tokens[i].text), tokens[i].quoted});
  }
}

SceneDescription SceneParser::finish(const std::string& path) {
  const SourceLocation whole{path, 0, 0};
  SceneDescription& scene = state_.scene;
  if (state_.open_mesh) {
    state_.diagnostics.add(diagnostic_at(state_.open_mesh->clauses.attributes.location,
                                         "the inline_mesh has no end; 'end' is expected after its faces"));
  }
  if (state_.diagnostics.empty()) {
    if (!state_.camera_at) {
      state_.diagnostics.add(
          diagnostic_at(whole, "the scene has no camera; one camera statement is expected"));
    }
    if (scene.polygons.empty() && scene.spheres.empty() && scene.meshes.empty()) {
      const std::string why = state_.shape_statements > 0 ? " left, all its shapes were degenerate" : "";
      state_.diagnostics.add(
          diagnostic_at(whole, "the scene has no shape" + why + "; at least one is expected"));
    }
  }
  state_.diagnostics.throw_if_any();

  bool lit = false;
  for (const PolygonDescription& polygon : scene.polygons)
    lit = lit || polygon.attributes.emission.has_value();
  for (const SphereDescription& sphere : scene.spheres) lit = lit || sphere.attributes.emission.has_value();
  for (const MeshDescription& mesh : scene.meshes) lit = lit || mesh.attributes.emission.has_value();
  if (!lit) state_.diagnostics.warn(whole, "the scene has no light; its image is black");
  warn_of_lost_precision(scene, state_.diagnostics);
  scene.path = path;
  scene.warnings = state_.diagnostics.warnings();
  return std::move(scene);
}

SceneDescription parse(SceneParser& parser, const SourceFile& file, const std::string& name) {
  try {
    parser.parse_file(file);
    return parser.finish(name);
  } catch (const std::bad_alloc&) {
    throw ResourceError(name + ": the machine has no memory left for the scene");
  }
}

}  // namespace

SceneDescription parse_scene_file(const std::string& path) {
  if (path.empty())
    throw InputError(Diagnostic{"scene", 0, 0, "the path is empty; a scene file is expected"});
  SceneParser parser{SourceFolder(path)};
  const SourceFile file = parser.folder().read_scene(path);
  return parse(parser, file, path);
}

SceneDescription parse_scene_text(std::string_view text, const std::string& name) {
  SceneParser parser{SourceFolder()};
  SourceFile file;
  file.shown_path = name;
  file.bytes = std::make_unique_for_overwrite<char[]>(text.size());
  text.copy(file.bytes.get(), text.size());
  file.size = text.size();
  return parse(parser, file, name);
}

}  // namespace mlt
