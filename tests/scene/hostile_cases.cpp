#include "hostile_cases.hpp"

#include "scene_text.hpp"

namespace mlt::test {
namespace {

using enum Answer;

const std::string kNul("@\0", 2);

std::string repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

const std::vector<HostileCase> kTextCases = {
    {"empty file", "", kInputError, "scene.txt: ", "no camera"},
    {"comments only", "# nothing\n", kInputError, "scene.txt: ", "no shape"},
    {"binary file",
     std::string("\x7f"
                 "ELF\x02\x01",
                 6),
     kInputError, "scene.txt:1:1: ", "control byte '\\x7f'"},
    {"NUL byte", kNul, kInputError, "scene.txt:4:1: ", "control byte '\\x00'"},
    {"UTF-16",
     std::string("\xff\xfe"
                 "f\0i\0",
                 6),
     kInputError, "scene.txt:1:4: ", "control byte"},
    {"terminal escape", "@\x1b[2J", kInputError, "scene.txt:4:1: ", "'\\x1b'"},
    {"byte order mark", "\xef\xbb\xbf@", kAccepted, "", ""},
    {"unknown word", "@sper 0 0 0 1", kInputError,
     "scene.txt:4:1: ", "'sper' is not a statement, did you mean 'sphere'"},
    {"unknown word, nothing near", "@xyzzyplugh", kInputError,
     "scene.txt:4:1: ", "allowed: include, define, film"},
    {"wrong case", "@Sphere 0 0 0 1 material m", kInputError, "scene.txt:4:1: ", "did you mean 'sphere'"},
    {"too few numbers", "@sphere 0 0 0", kInputError,
     "scene.txt:4:13: ", "the line ends where the radius is expected"},
    {"too many numbers", "@sphere 0 0 0 1 2 material m", kInputError,
     "scene.txt:4:16: ", "'2' is not a clause of a shape"},
    {"not a number", "@sphere 0 zero 0 1 material m", kInputError,
     "scene.txt:4:10: ", "'zero' is not a number"},
    {"decimal comma", "@sphere 0 0 0 1,5 material m", kInputError,
     "scene.txt:4:14: ", "'1,5' is not a number"},
    {"trailing garbage", "@sphere 0 0 0 1.5x material m", kInputError,
     "scene.txt:4:14: ", "'1.5x' is not a number"},
    {"hexadecimal", "@sphere 0 0 0 0x10 material m", kInputError,
     "scene.txt:4:14: ", "'0x10' is not a number"},
    {"NaN", "@sphere nan 0 0 1 material m", kInputError, "scene.txt:4:8: ", "'nan' is not a finite number"},
    {"infinity", "@sphere 0 -inf 0 1 material m", kInputError,
     "scene.txt:4:10: ", "'-inf' is not a finite number"},
    {"1e999", "@sphere 0 0 1e999 1 material m", kInputError,
     "scene.txt:4:12: ", "'1e999' is too large or too small"},
    {"coordinate 1e300", "@triangle 0 0 0 1e300 0 0 0 1 0 material m", kInputError,
     "scene.txt:4:1: ", "coordinates must lie in"},
    {"open quote", "@mesh \"a.obj", kInputError, "scene.txt:4:6: ", "the quote is not closed"},
    {"line of 1 MB", "@" + std::string(1000000, 'x'), kInputError,
     "scene.txt:4:65537: ", "at most 65536 are allowed"},
    {"word of 2000 bytes", "@" + std::string(2000, 'x'), kInputError,
     "scene.txt:4:1: ", "at most 1024 are allowed"},
    {"2000 words", "@" + repeated("1 ", 2000), kInputError, "scene.txt:4:2049: ", "more than 1024 words"},
    {"unknown constant", "@sphere $where 1 material m", kInputError,
     "scene.txt:4:8: ", "no constant 'where'"},
    {"constant twice", "@define a 1\ndefine a 2", kInputError, "scene.txt:5:8: ", "already defined"},
    {"constant without value", "@define a", kInputError,
     "scene.txt:4:9: ", "the constant's value is expected"},
    {"constant with a bad name", "@define 1a 2", kInputError,
     "scene.txt:4:8: ", "'1a' cannot be the constant's name"},
    {"constant of itself", "@define a $a", kInputError, "scene.txt:4:10: ", "no constant 'a'"},
};

/// A scene that lacks only a camera.
const std::string kRest = "material m diffuse reflectance 1\nsphere 0 0 0 1 material m emit 1\n";

const std::vector<HostileCase> kSettingCases = {
    {"no camera", kRest, kInputError, "scene.txt: ", "the scene has no camera"},
    {"no shape", "camera eye 0 0 1 target 0 0 0", kInputError, "scene.txt: ", "the scene has no shape"},
    {"no shape left",
     "camera eye 0 0 1 target 0 0 0\nmaterial m diffuse reflectance 1\ntriangle 0 0 0 0 0 0 0 0 0 material "
     "m",
     kInputError, "scene.txt: ", "all its shapes were degenerate"},
    {"no light", "camera eye 0 0 1 target 0 0 0\nmaterial m diffuse reflectance 1\nsphere 0 0 0 1 material m",
     kWarning, "scene.txt: ", "the scene has no light"},
    {"second camera", "@camera eye 0 0 1 target 0 0 0", kInputError, "scene.txt:4:1: ", "a second camera"},
    {"camera without eye", "camera target 0 0 0\n" + kRest, kInputError,
     "scene.txt:1:20: ", "the camera has no eye"},
    {"camera at its target", "camera eye 1 2 3 target 1 2 3\n" + kRest, kInputError,
     "scene.txt:1:1: ", "the same point"},
    {"camera with up along the view", "camera eye 0 5 0 target 0 0 0\n" + kRest, kInputError,
     "scene.txt:1:1: ", "parallel"},
    {"camera with up 0", "camera eye 0 5 0 target 1 0 0 up 0 0 0\n" + kRest, kInputError,
     "scene.txt:1:1: ", "length 0"},
    {"fov 0", "camera eye 0 0 1 target 0 0 0 fov 0\n" + kRest, kInputError,
     "scene.txt:1:35: ", "allowed is in [0.001, 179]"},
    {"fov 180", "camera eye 0 0 1 target 0 0 0 fov 180\n" + kRest, kInputError,
     "scene.txt:1:35: ", "the field of view is 180"},
    {"eye twice", "camera eye 0 0 1 eye 0 0 2 target 0 0 0\n" + kRest, kInputError,
     "scene.txt:1:18: ", "eye is given twice"},
    {"film 0", "@film 0 10", kInputError, "scene.txt:4:6: ", "the film's width is 0"},
    {"film negative", "@film 10 -1", kInputError, "scene.txt:4:9: ", "the film's height is -1"},
    {"film 100000", "@film 100000 1", kInputError, "scene.txt:4:6: ", "from 1 to 65536"},
    {"film of 20 digits", "@film 99999999999999999999 1", kInputError, "scene.txt:4:6: ", "too large"},
    {"film with a fraction", "@film 10.5 1", kInputError, "scene.txt:4:6: ", "not a whole number"},
    {"film with three numbers", "@film 1 2 3", kInputError, "scene.txt:4:10: ", "one word too many"},
    {"film 1x1", "@film 1 1", kAccepted, "", ""},
    {"film 65536x65536", "@film 65536 65536", kAccepted, "", ""},
    {"depth 0", "@depth 0", kInputError,
     "scene.txt:4:7: ", "the depth is 0; the depth is a whole number from 1 to 256"},
    {"depth 1000", "@depth 1000", kInputError, "scene.txt:4:7: ", "the depth is 1000"},
    {"depth twice", "@depth 3\ndepth 4", kInputError, "scene.txt:5:1: ", "a second depth"},
    {"unknown kind", "@material q glas", kInputError, "scene.txt:4:12: ", "'glas' is not a kind of material"},
    {"material twice", "@material m mirror reflectance 1", kInputError,
     "scene.txt:4:10: ", "a second material 'm'"},
    {"material without parameters", "@material q diffuse", kInputError,
     "scene.txt:4:19: ", "needs reflectance"},
    {"albedo 1.1", "@material q diffuse reflectance 0 0 1.1", kInputError,
     "scene.txt:4:36: ", "allowed is in [0, 1]"},
    {"albedo negative", "@material q diffuse reflectance -0.1", kInputError, "scene.txt:4:32: ", "is -0.1"},
    {"two channels", "@material q diffuse reflectance 1 1", kInputError, "scene.txt:4:35: ", "the line ends"},
    {"ior 0.5", "@material q dielectric ior 0.5", kInputError, "scene.txt:4:27: ", "allowed is in [1, 3]"},
    {"roughness 1e-6", "@material q conductor preset gold roughness 1e-6", kInputError,
     "scene.txt:4:44: ", "0 or in [1e-05, 1]"},
    {"roughness 2", "@material q conductor preset gold roughness 2", kInputError,
     "scene.txt:4:44: ", "the roughness is 2"},
    {"unknown metal", "@material q conductor preset golf", kInputError,
     "scene.txt:4:29: ", "did you mean 'gold'"},
    {"eta without k", "@material q conductor eta 1", kInputError,
     "scene.txt:4:27: ", "needs preset, or both eta and k"},
    {"preset and eta", "@material q conductor preset gold eta 1 k 1", kInputError,
     "scene.txt:4:1: ", "not both"},
    {"parameter of another kind", "@material q diffuse ior 1.5", kInputError,
     "scene.txt:4:20: ", "diffuse has no parameter 'ior'"},
};

const std::vector<HostileCase> kShapeCases = {
    {"no material", "@sphere 0 0 0 1", kInputError, "scene.txt:4:15: ", "the shape has no material"},
    {"unknown material", "@sphere 0 0 0 1 material n", kInputError,
     "scene.txt:4:25: ", "no material 'n' stands before"},
    {"material twice in a shape", "@sphere 0 0 0 1 material m material m", kInputError,
     "scene.txt:4:27: ", "given twice"},
    {"unknown clause", "@sphere 0 0 0 1 material m emmit 1", kInputError,
     "scene.txt:4:27: ", "did you mean 'emit'"},
    {"negative emission", "@sphere 0 0 0 1 material m emit -1", kInputError,
     "scene.txt:4:32: ", "allowed is in [0, 1e+12]"},
    {"emission 0", "@sphere 0 0 0 1 material m emit 0", kWarning, "scene.txt:4:27: ", "emission of 0"},
    {"radius negative", "@sphere 0 0 0 -1 material m", kInputError, "scene.txt:4:14: ", "the radius is -1"},
    {"radius 0, a light", "@sphere 0 0 0 0 material m emit 1", kWarning,
     "scene.txt:4:1: ", "it was to emit light"},
    {"inward sphere", "@sphere 0 0 0 1 material m inward", kInputError,
     "scene.txt:4:27: ", "allowed after box"},
    {"degenerate triangle", "@triangle 0 0 0 1 1 1 2 2 2 material m", kWarning,
     "scene.txt:4:1: ", "degenerate triangle"},
    {"light of zero area", "@quad 0 0 0 1 0 0 1 0 0 0 0 0 material m emit 9", kWarning,
     "scene.txt:4:1: ", "emit light"},
    {"duplicate triangles", "@triangle 0 0 0 1 0 0 0 1 0 material m\ntriangle 0 0 0 1 0 0 0 1 0 material m",
     kAccepted, "", ""},
    {"quad not planar", "@quad 0 0 0 1 0 0 1 1 1 0 1 0 material m", kInputError,
     "scene.txt:4:1: ", "not planar"},
    {"quad crossed", "@quad 0 0 0 1 1 0 1 0 0 0 1 0 material m", kInputError,
     "scene.txt:4:1: ", "crosses itself"},
    {"box upside down", "@box 0 0 0 1 -1 1 material m", kInputError,
     "scene.txt:4:1: ", "less than the second on every axis"},
    {"box flat", "@box 0 0 0 1 0 1 material m", kInputError, "scene.txt:4:1: ", "a flat box is a quad"},
    {"singular scale", "@box 0 0 0 1 1 1 material m scale 1 0 1", kInputError,
     "scene.txt:4:28: ", "singular"},
    {"singular rotation", "@box 0 0 0 1 1 1 material m rotate 90 0 0 0", kInputError,
     "scene.txt:4:28: ", "length 0"},
    {"sphere out of round", "@sphere 0 0 0 1 material m scale 1 1 2", kInputError,
     "scene.txt:4:1: ", "unevenly"},
    {"rotation of 1e9 degrees", "@box 0 0 0 1 1 1 material m rotate 1e9 0 1 0", kInputError,
     "scene.txt:4:35: ", "[-3600, 3600]"},
    {"inline mesh without end", "@inline_mesh material m\nvertex 0 0 0", kInputError,
     "scene.txt:4:1: ", "has no end"},
    {"inline mesh broken off", "@inline_mesh material m\nsphere 0 0 0 1 material m", kInputError,
     "scene.txt:5:1: ", "is still open"},
    {"index out of range",
     "@inline_mesh material m\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nface 0 1 3\nend", kInputError,
     "scene.txt:8:10: ", "is 3; the index of a vertex above is a whole number from 0 to 2"},
    {"negative index", "@inline_mesh material m\nvertex 0 0 0\nface 0 0 -1\nend", kInputError,
     "scene.txt:6:10: ", "is -1"},
    {"face before vertices", "@inline_mesh material m\nface 0 1 2\nend", kInputError,
     "scene.txt:5:1: ", "before the first vertex"},
    {"face of two", "@inline_mesh material m\nvertex 0 0 0\nface 0 0\nend", kInputError,
     "scene.txt:6:9: ", "the line ends"},
    {"vertex outside", "@vertex 0 0 0", kInputError, "scene.txt:4:1: ", "outside of inline_mesh"},
    {"end outside", "@end", kInputError, "scene.txt:4:1: ", "outside of inline_mesh"},
};

const std::vector<HostileCase> kFileCases = {
    {"missing include", "@include a.txt", kInputError, "scene.txt:4:9: ", "cannot be read: No such file"},
    {"missing mesh", "@mesh a.obj material m", kInputError,
     "scene.txt:4:6: ", "cannot be read: No such file"},
    {"include of itself", "@include scene.txt", kInputError, "scene.txt:4:9: ", "includes itself"},
    {"include cycle", "@include a.txt", kInputError, "a.txt:1:9: ", "includes itself", "a.txt",
     "include scene.txt"},
    {"include of a directory", "@include .", kInputError,
     "scene.txt:4:9: ", "is a directory; a regular file is expected"},
    {"include through ..", "@include ../x.txt", kInputError, "scene.txt:4:9: ", "leaves the scene's folder"},
    {"include through .. later", "@include a/../../x.txt", kInputError,
     "scene.txt:4:9: ", "leaves the scene's folder"},
    {"absolute include", "@include /etc/hostname", kInputError, "scene.txt:4:9: ", "is absolute"},
    {"absolute mesh", "@mesh /dev/zero.obj material m", kInputError, "scene.txt:4:6: ", "is absolute"},
    {"include without a name", "@include", kInputError,
     "scene.txt:4:8: ", "the name of a scene file is expected"},
    {"include with an empty name", "@include \"\"", kInputError, "scene.txt:4:9: ", "the file name is empty"},
    {"fault in an included file", "@include a.txt", kInputError, "a.txt:2:1: ", "'oops' is not a statement",
     "a.txt", "\noops"},
    {"mesh of no known kind", "@mesh a.stl material m", kInputError,
     "scene.txt:4:6: ", "neither in .obj nor in .ply"},
    {"good include", "@include sub/../a.txt", kAccepted, "", "", "a.txt", "sphere 0 0 0 1 material m"},
};

HostileCase obj(const std::string& name, const std::string& bytes, Answer answer, const std::string& place,
                const std::string& fragment) {
  return {name, "@mesh m.obj material m emit 1", answer, place, fragment, "m.obj", bytes};
}

HostileCase ply(const std::string& name, const std::string& bytes, Answer answer, const std::string& place,
                const std::string& fragment) {
  return {name, "@mesh m.ply material m emit 1", answer, place, fragment, "m.ply", bytes};
}

std::string ply_header(const std::string& format, const std::string& vertices, const std::string& faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::string kBinary = ply_header("binary_little_endian", "3", "1");

const std::vector<HostileCase> kObjCases = {
    obj("OBJ empty", "", kInputError, "m.obj: ", "0 vertices and no face"),
    obj("OBJ of points", kSquare, kInputError, "m.obj: ", "4 vertices and no face"),
    obj("OBJ NaN", "v nan 0 0\n", kInputError, "m.obj:1:3: ", "not a finite number"),
    obj("OBJ 1e999", "v 0 1e999 0\n", kInputError, "m.obj:1:5: ", "too large"),
    obj("OBJ index 0", kSquare + "f 0 1 2\n", kInputError, "m.obj:5:3: ", "vertex index 0 is out of range"),
    obj("OBJ index beyond", kSquare + "f 1 2 5\n", kInputError,
        "m.obj:5:7: ", "vertex index 5 is out of range"),
    obj("OBJ index of 20 digits", kSquare + "f 1 2 99999999999999999999\n", kInputError,
        "m.obj:5:7: ", "no corner"),
    obj("OBJ negative index beyond", kSquare + "f -5 1 2\n", kInputError,
        "m.obj:5:3: ", "-5 is out of range"),
    obj("OBJ face of two", kSquare + "f 1 2\n", kInputError, "m.obj:5:6: ", "has 2 corners"),
    obj("OBJ coordinates 1e300", "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3", kInputError,
        "scene.txt:4:1: ", "must lie in"),
    obj("OBJ binary noise", std::string("\0\xff\x80\x01", 4), kInputError, "m.obj: ", "no face"),
    obj("OBJ unknown words", kSquare + "frobnicate\nf 1 2 3", kWarning,
        "m.obj: ", "unknown OBJ statements ignored"),
    obj("OBJ degenerate triangles", kSquare + "f 1 1 2\nf 1 2 3\nf 2 2 2", kWarning,
        "scene.txt:4:1: ", "2 degenerate"),
    obj("OBJ polygon of 2000", kSquare + "f" + repeated(" 1", 2000), kInputError,
        "m.obj:5:2051: ", "more than 1024"),

};

const std::vector<HostileCase> kPlyCases = {
    ply("PLY empty", "", kInputError, "m.ply:1:1: ", "does not begin with a line 'ply'"),
    ply("PLY header cut", "ply\nformat ascii 1.0\nelement ver", kInputError,
        "m.ply:3:12: ", "the number of elements"),
    ply("PLY big-endian", "ply\nformat binary_big_endian 1.0\n", kInputError,
        "m.ply:2:8: ", "binary_little_endian are allowed"),
    ply("PLY of 1e9 vertices", ply_header("binary_little_endian", "1000000000", "1") + "0123456789",
        kInputError, "m.ply:3:9: ", "only 10 bytes follow"),
    ply("PLY of 1e9 faces", ply_header("ascii", "0", "1000000000") + "0123456789", kInputError,
        "m.ply:7:9: ", "only 10 bytes follow"),
    ply("PLY of 2^63 vertices", ply_header("ascii", "9223372036854775808", "1"), kInputError,
        "m.ply:3:16: ", "not a number of elements"),
    ply("PLY data cut", kBinary + std::string(36, '\0') + "\3" + std::string(3, '\0'), kInputError,
        "m.ply: ", "'face' 0: the file ends"),
    ply("PLY face of none", kBinary + std::string(37, '\0'), kInputError,
        "m.ply: ", "the face has 0 corners"),
    ply("PLY all vertices equal", kBinary + std::string(36, '\0') + "\3" + std::string(12, '\0'), kWarning,
        "scene.txt:4:1: ", "without a triangle dropped"),
    ply("PLY index beyond", kBinary + std::string(36, '\0') + std::string("\3\0\0\0\0\0\0\0\0\3\0\0\0", 13),
        kInputError, "m.ply: ", "vertex index 3 is out of range"),
    ply("PLY index negative", kBinary + std::string(36, '\0') + "\3" + std::string(12, '\xff'), kInputError,
        "m.ply: ", "vertex index -1 is out of range"),
    ply("PLY NaN", kBinary + std::string(12, '\xff') + std::string(37, '\0'), kInputError,
        "m.ply: ", "'vertex' 0: the coordinate x is not a finite number"),
    ply("PLY ascii cut", ply_header("ascii", "1", "1") + "0 0 0 3 0 0", kInputError,
        "m.ply:10:12: ", "the file ends"),
    ply("PLY of points", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
        kInputError, "m.ply: ", "no element 'face'"),
};

std::vector<HostileCase> joined(std::initializer_list<std::vector<HostileCase>> parts) {
  std::vector<HostileCase> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

const std::vector<HostileCase>& hostile_scenes() {
  static const std::vector<HostileCase> cases = joined({kTextCases, kSettingCases, kShapeCases, kFileCases});
  return cases;
}

const std::vector<HostileCase>& hostile_meshes() {
  static const std::vector<HostileCase> cases = joined({kObjCases, kPlyCases});
  return cases;
}

}  // namespace mlt::test
