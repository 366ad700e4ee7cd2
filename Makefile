# Builds mlt, its tests and everything that checks it.
#   make            build/mlt                          make demo     renders scenes/cornell_hidden.txt
#   make test       all tests, lint and quick proofs   make unit T=math   the tests of one stage
#   make slow       tests with the tag [.slow]         make scenes, refs, refs256, bench, feature-cost, fuzz, repro, proof
#   make stress     numerical sweeps with their tables (docs/STABILITY.md); a short part runs in make test
#   make asan tsan  all tests under a sanitizer        make memcheck, tidy, format-check, clean
# A variant is a compiler with flags; each has a folder of its own below build/ and a name, listed in
# tools/variants.mk: `make VARIANT=clang test`. Its values can be overridden: `make VARIANT=mine OPT=-O3`.
# V=1 prints whole commands.
# The floating-point flags hold for every variant (docs/ARCHITECTURE.md, floating-point contract).

VARIANT  ?= release
Q        := $(if $(V),,@)
SAY      := $(if $(V),@:,@echo)
# As many jobs as there are cores, unless -j says otherwise.
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc)
endif
ifeq ($(origin CXX),default)
CXX      := g++
endif
include tools/variants.mk

CXX      ?= g++
# The compiler is asked below what it builds for, so it must be there before the rules are read.
ifeq ($(shell command -v $(firstword $(CXX)))$(filter clean,$(MAKECMDGOALS)),)
ifneq ($(shell tools/install_deps.sh build '$(CXX)' >&2 || echo failed),)
$(error $(CXX) is not installed)
endif
endif
OPT      ?= -O2
EXTRA    ?=
LINK     ?=
OUT      := build/$(VARIANT)

# The stages of the data flow; each may include only itself and earlier ones.
STAGES   := base math scene geometry material light world integrator markov film image render compare converge app

CONTRACT := -std=c++20 -ffp-contract=off -fno-math-errno -fno-trapping-math
# Vectors wider than a register pass between inline functions alone, so that no calling convention is involved.
WARNINGS := -Wall -Wextra -Wpedantic -Wshadow -Werror -Wno-psabi
# One section a function lets the proofs follow what is reachable from the render loop (tools/proof.sh).
CXXFLAGS  = $(CONTRACT) $(WARNINGS) $(OPT) $(EXTRA) -g1 -ffunction-sections -fdata-sections -MMD -MP -Iinclude \
            -Itests $(if $(EXR),-DMLT_HAS_OPENEXR) $(UNOPTIMISED) $(if $(findstring /kernel_group_,$@),$(KERNEL_INLINING))
# g++ limits how far inlining lets a source grow. With the default of 40 % a kernel's code would depend on what else
# its source holds, and a plain scene pay 3 % for features of others (tools/feature_cost.sh).
# What is precompiled would bring its own limit along.
KERNEL_INLINING := $(if $(findstring clang,$(CXX)),,--param inline-unit-growth=400)
LDFLAGS  := $(OPT) $(EXTRA) $(LINK) -Wl,-z,now -pthread
# For include/render/worker_pool.hpp: a pragma in what is precompiled of fmt leaves __OPTIMIZE__ defined.
UNOPTIMISED = $(if $(findstring -O0,$(OPT) $(EXTRA)),-DMLT_LARGE_STACKS=1)
# OpenEXR is asked for by EXR=yes or the variant `exr`: its libraries would take 1.2 of the 16 MB of a small job.
EXR      ?=
IMAGE_LIBS := -lpng $(if $(EXR),-lOpenEXR -lIex)
LIBS     ?= -lfmt $(IMAGE_LIBS)

sources   = $(wildcard src/$(1)/*.cpp)
objects   = $(patsubst %.cpp,$(OUT)/%.o,$(1))
# Stage $(1) and all before it that it may need: renders need nothing of images, nor their libraries.
upto      = $(if $(1),$(eval _found :=)$(foreach s,$(STAGES),$(if $(_found),,$(s)$(if $(filter $(1),$(s)),$(eval _found := 1)))))
MAIN      := src/app/main.cpp
stage_objects = $(call objects,$(filter-out $(MAIN),$(foreach s,$(filter-out $(if $(filter \
                  render,$(1)),image),$(call upto,$(1))),$(call sources,$(s))))) \
                $(if $(filter render,$(call upto,$(1))),$(KERNEL_SETS))

# Instruction sets beyond the variant's own (include/render/kernel_set.hpp). Sanitizers and link-time
# optimisation do not survive the relocatable link.
EXTRA_SETS := $(if $(findstring x86_64,$(shell $(CXX) -dumpmachine)),$(if \
  $(or $(findstring -fsanitize,$(EXTRA)),$(findstring -flto,$(EXTRA)),$(findstring -m,$(EXTRA))),,avx2 avx512))
KERNEL_SETS := $(EXTRA_SETS:%=$(OUT)/kernel_set_%.o)
SET_SOURCES := $(wildcard src/render/kernel*.cpp src/geometry/*.cpp src/world/*.cpp)
# What include/render/instruction_set.hpp asks the processor for (the lint compares). No -mprefer-vector-width: with
# 256, clang splits the kernels' explicit vectors of 16 lanes, and g++ only copies memory in smaller pieces.
SET_FLAGS_avx2 := -mavx2 -mfma
# g++ would copy values of eight lanes in halves, and who reads them whole right after waits for both.
COPY_FLAGS_avx2 := $(if $(findstring clang,$(CXX)),,-mmove-max=256 -mstore-max=256)
SET_FLAGS_avx512 := -mavx512f -mavx512vl -mavx512dq -mavx512bw -mavx2 -mfma -mbmi -mbmi2
# Lines of films are asked for to be written: one that another processor has written lately would have to be asked for
# again. Processors of x86-64 that do not know the instruction take it for none. Symbols of binding "unique", an
# extension of g++, would stay global. The values that its AVX-512 header leaves to chance on purpose are reported as
# mistakes of ours.
SET_FLAGS := -mprfchw $(if $(findstring clang,$(CXX)),,-fno-gnu-unique)
AVX512_QUIET := $(if $(findstring clang,$(CXX)),,-Wno-uninitialized -Wno-maybe-uninitialized)
$(OUT)/avx512/%.o: private WARNINGS += $(AVX512_QUIET)

# A variant whose flags have changed is built anew: every object depends on this file.
FLAGS_FILE := $(OUT)/flags
FLAGS_TEXT := $(CXX) $(CXXFLAGS) $(KERNEL_INLINING) $(SET_FLAGS) $(SET_FLAGS_avx2) $(COPY_FLAGS_avx2) $(SET_FLAGS_avx512) $(LDFLAGS) $(LIBS)
ifeq ($(filter clean format-check,$(MAKECMDGOALS)),)
$(shell mkdir -p $(OUT); printf '%s\n' '$(FLAGS_TEXT)' | cmp -s - $(FLAGS_FILE) || \
  printf '%s\n' '$(FLAGS_TEXT)' > $(FLAGS_FILE))
endif

.PHONY: all deps deps-test deps-extra unit tests test slow stress demo scenes refs refs256 bench benches bench-guard feature-cost calibration fuzz fuzzers golden \
        planted-weight repro proof memcheck asan tsan tidy format-check clean
all: build/mlt

build/mlt: $(OUT)/mlt
	@mkdir -p build
	@ln -sf $(VARIANT)/mlt build/mlt

# Without line numbers, three quarters of the file; names of functions stay for profilers. The reports of sanitizers
# need both, and proofs read the objects and film_hash.
$(OUT)/mlt: private LDFLAGS += $(if $(findstring -fsanitize,$(EXTRA)),,-Wl,--strip-debug)
$(OUT)/mlt: $(call stage_objects,app) $(call objects,$(MAIN))
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) $^ $(LIBS) -o $@

# The code of a set, from objects into one, in a section of its own: what a render does not use need not be in memory.
IN_ONE_SECTION = echo 'SECTIONS { kernels_$(1) : { *(.text .text.*) } }' >$(3).ld && \
  ld -r --force-group-allocation -T $(3).ld $(2) -o $(3) && rm $(3).ld
define KERNEL_SET
$(OUT)/$(1)/%.o: src/%.cpp $$(FLAGS_FILE) | deps
	@mkdir -p $$(dir $$@)
	$$(SAY) "  compile $$@"
	$$(Q)$$(CXX) $$(CXXFLAGS) $$(SET_FLAGS) $$(SET_FLAGS_$(1)) $$(COPY_FLAGS_$(1)) -DMLT_KERNEL_SET=mlt_kernel_set_$(1) -c $$< -o $$@

$(OUT)/kernel_set_$(1).o: $$(patsubst src/%.cpp,$(OUT)/$(1)/%.o,$$(SET_SOURCES))
	$$(SAY) "  combine $$@"
	$$(Q)$$(call IN_ONE_SECTION,$(1),$$^,$$@.all)
	$$(Q)objcopy --keep-global-symbol=mlt_kernel_set_$(1) $$@.all $$@
	@rm $$@.all
endef
$(foreach s,$(EXTRA_SETS),$(eval $(call KERNEL_SET,$(s))))
# Blocks and nodes have eight lanes in both (math/simd.hpp), and what builds them is compiled once; rays are traced
# by inline functions of the kernels.
define SHARED_STAGE
$(OUT)/avx512/$(1)/%.o: $(OUT)/avx2/$(1)/%.o
	@mkdir -p $$(dir $$@)
	@ln -f $$< $$@
endef
$(foreach s,geometry world,$(eval $(call SHARED_STAGE,$(s))))

# Headers of the library and fmt take a fifth to a third of the time that most sources compile. g++ reads them
# precompiled; other compilers, which the tests run with too, see to it that a source includes what it uses. In what
# is precompiled g++ forgets which headers are the system's, and shows warnings about joined strings that are not
# true (gcc bug 105651).
USE_PCH     := $(if $(findstring clang,$(CXX))$(findstring aarch64,$(CXX)),,yes)
PCH_HEADERS := algorithm array atomic bit cmath cstdint filesystem limits memory optional span string string_view \
               vector fmt/core.h
SOURCE_PCH  := $(if $(USE_PCH),$(OUT)/sources.hpp.gch)
READ_PCH     = -include $(OUT)/$(1).hpp -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread
$(OUT)/sources.hpp.gch: $(FLAGS_FILE) | deps
	$(SAY) "  compile $@"
	@printf '#include <%s>\n' $(PCH_HEADERS) > $(OUT)/sources.hpp
	$(Q)$(CXX) $(CXXFLAGS) -x c++-header $(OUT)/sources.hpp -o $@

# Private: what is precompiled for this source is so for all.
$(OUT)/src/image/exr.o: private CONTRACT += -isystem /usr/include/OpenEXR -isystem /usr/include/Imath
$(OUT)/src/%.o: src/%.cpp $(FLAGS_FILE) $(SOURCE_PCH) | deps
	@mkdir -p $(dir $@)
	$(SAY) "  compile $@"
	$(Q)$(CXX) $(CXXFLAGS) $(if $(SOURCE_PCH),$(if $(findstring /kernel_group_,$@),,$(call READ_PCH,sources))) -c $< -o $@
	$(if $(and $(EXTRA_SETS),$(findstring /kernel_group_,$@)),$(Q)$(call IN_ONE_SECTION,base,$@,$@.one) && mv $@.one $@)

# Tests include Catch, whose templates g++ warns about under a sanitizer (gcc bug 105562): its own main is
# compiled without warnings.
$(OUT)/tests/support/catch_main.o: WARNINGS := -w
# Half of the time of `make test` from clean is spent on compiling tests, of which -O1 saves a third; what is
# measured or hashed keeps the variant's optimisation.
TEST_OPT := $(if $(filter -O2,$(OPT)),-O1,$(OPT))
VARIANT_OPT := $(OPT)
$(OUT)/tests/%.o: OPT := $(TEST_OPT)
$(OUT)/tests/bench/%.o: OPT := $(VARIANT_OPT)
$(OUT)/tests/repro/%.o: OPT := $(VARIANT_OPT)
# Catch's header takes a third of a test's time to compile. g++ reads it precompiled, for tests that have the
# flags of most; what is not a Catch test does without.
TEST_PCH := $(if $(USE_PCH),$(OUT)/tests.hpp.gch)
NO_CATCH := $(addprefix $(OUT)/tests/,bench/% repro/% fuzz/% support/catch_main.o golden/make_refs.o golden/golden.o)
$(OUT)/tests.hpp.gch: OPT := $(TEST_OPT)
$(OUT)/tests.hpp.gch: $(FLAGS_FILE) | deps-test
	$(SAY) "  compile $@"
	@printf '#include <%s>\n' $(PCH_HEADERS) catch2/catch.hpp > $(OUT)/tests.hpp
	$(Q)$(CXX) $(CXXFLAGS) -x c++-header $(OUT)/tests.hpp -o $@
$(OUT)/tests/%.o: tests/%.cpp $(FLAGS_FILE) $(TEST_PCH) | deps-test
	@mkdir -p $(dir $@)
	$(SAY) "  compile $@"
	$(Q)$(CXX) $(CXXFLAGS) $(if $(TEST_PCH),$(if $(filter-out $(NO_CATCH),$@),$(call READ_PCH,tests))) -c $< -o $@

# What a target needs of the system; does nothing when it is there (tools/install_deps.sh).
deps:
	@tools/install_deps.sh build $(CXX)
	@$(if $(EXR),tools/install_deps.sh exr)
deps-test: deps
	@tools/install_deps.sh test $(CXX)
deps-extra: deps-test
	@tools/install_deps.sh extra

# ---- tests ----

TESTED_STAGES := $(foreach s,$(STAGES),$(if $(wildcard tests/$(s)/*.cpp),$(s)))
SUPPORT       := $(wildcard tests/support/*.cpp)
define STAGE_TEST
$(OUT)/test_$(1): $$(call objects,$$(wildcard tests/$(1)/*.cpp) $$(SUPPORT)) $$(call stage_objects,$(1))
	$$(SAY) "  link    $$@"
	$$(Q)$$(CXX) $$(LDFLAGS) $$^ $$(LIBS) -o $$@
endef
$(foreach s,$(STAGES),$(eval $(call STAGE_TEST,$(s))))

TEST_BINARIES := $(foreach s,$(TESTED_STAGES),$(OUT)/test_$(s))
# The tests of render look at every scene, the generated mesh too.
$(OUT)/test_render: | build/scenes/made
# The tests of app run the program itself.
$(OUT)/test_app: | $(OUT)/mlt
export MLT_BINARY := $(OUT)/mlt

# What the proofs look at.
PROVED := $(OUT)/mlt $(OUT)/film_hash $(foreach k,1 2 3 4 5 6,$(OUT)/film_hash_fault$(k)) $(OUT)/malloc_guard.so

T ?= base
unit: $(OUT)/test_$(T)
	$(OUT)/test_$(T)

# Builds without running.
tests: $(TEST_BINARIES) $(OUT)/test_stress $(OUT)/film_hash

# TESTS narrows the stages, ONLY the cases to a tag: make VARIANT=tsan test TESTS=render ONLY=[threads]
TESTS ?= $(TESTED_STAGES) stress
test: $(foreach s,$(TESTS),$(OUT)/test_$(s)) $(if $(filter release,$(VARIANT)),$(PROVED))
	tools/run_tests.sh $(OUT) $(if $(ONLY),--only '$(ONLY)') $(TESTS)

slow: $(TEST_BINARIES)
	tools/run_tests.sh $(OUT) --only '[.slow]' $(TESTED_STAGES)

asan tsan:
	$(MAKE) VARIANT=$@ test

memcheck: $(OUT)/film_hash scenes
	tools/memcheck.sh $(OUT)

# Numerical sweeps over whole renders. Those with the tag [.stress] are too long for `make test`.
$(OUT)/test_stress: $(call objects,$(wildcard tests/stress/*.cpp) tests/render/render_fixture.cpp $(SUPPORT)) \
                    $(call stage_objects,render)
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) $^ $(filter-out $(IMAGE_LIBS),$(LIBS)) -o $@
stress: $(OUT)/test_stress
	tools/stress.sh $(OUT)

# Whole renders against the stored pictures of ref_images, and the program that makes these.
GOLDEN := $(call objects,tests/golden/golden.cpp tests/render/render_fixture.cpp tests/support/statistics.cpp)
$(OUT)/test_golden: $(call objects,tests/golden/golden_test.cpp tests/support/catch_main.cpp) $(GOLDEN) \
                    $(call stage_objects,compare)
$(OUT)/make_refs: $(call objects,tests/golden/make_refs.cpp) $(GOLDEN) $(call stage_objects,compare)
$(OUT)/test_golden $(OUT)/make_refs:
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) $^ $(LIBS) -o $@
golden: $(OUT)/test_golden scenes
	tools/run_tests.sh $(OUT) golden
refs: $(OUT)/make_refs scenes
	$(OUT)/make_refs
# Of 256 pixels, for `make bench`: half an hour of one core.
refs256: $(OUT)/make_refs scenes
	$(OUT)/make_refs --large

# The agreement of PSSMLT with the path tracer, when chains lose weight (include/base/planted_fault.hpp).
WEIGHTED := $(filter src/render/kernel_group_%.cpp,$(call sources,render))
$(OUT)/fault7/%.o: src/%.cpp $(FLAGS_FILE)
	@mkdir -p $(dir $@)
	$(SAY) "  compile $@"
	$(Q)$(CXX) $(CXXFLAGS) -DMLT_PLANTED_FAULT=7 -c $< -o $@
$(OUT)/test_render_fault7: $(patsubst src/%.cpp,$(OUT)/fault7/%.o,$(WEIGHTED)) \
    $(call objects,tests/render/agreement_test.cpp tests/render/render_fixture.cpp $(SUPPORT)) \
    $(filter-out $(KERNEL_SETS) $(call objects,$(WEIGHTED)),$(call stage_objects,render))
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) $^ $(filter-out $(IMAGE_LIBS),$(LIBS)) -o $@
planted-weight: $(OUT)/test_render_fault7
	tools/planted_weight_test.sh $(OUT)

# ---- the same bits everywhere, and fixed memory ----

# All of the renderer without libpng, so that it can be linked for other machines too.
# -rdynamic lets the preloaded malloc guard see the mark of the render zone.
$(OUT)/film_hash: $(call objects,tests/repro/film_hash.cpp) $(call stage_objects,render)
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) -rdynamic $^ $(filter-out $(IMAGE_LIBS),$(LIBS)) -o $@

# The same with a fault planted in the render loop (include/base/planted_fault.hpp).
PLANTED := $(OUT)/src/render/worker_pool.o
$(OUT)/fault%/worker_pool.o: src/render/worker_pool.cpp $(FLAGS_FILE)
	@mkdir -p $(dir $@)
	$(SAY) "  compile $@"
	$(Q)$(CXX) $(CXXFLAGS) -DMLT_PLANTED_FAULT=$* -c $< -o $@
$(OUT)/film_hash_fault%: $(OUT)/fault%/worker_pool.o $(call objects,tests/repro/film_hash.cpp) \
                         $(filter-out $(PLANTED),$(call stage_objects,render))
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) -rdynamic $^ $(filter-out $(IMAGE_LIBS),$(LIBS)) -o $@

$(OUT)/malloc_guard.so: tests/proof/malloc_guard.cpp $(FLAGS_FILE) | deps
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(CONTRACT) $(WARNINGS) -O2 -g -fPIC -shared -Iinclude $< -o $@ -ldl

proof: $(PROVED)
	tools/proof.sh $(OUT)

repro: deps-extra
	tools/repro.sh full

# ---- pictures, measurements, fuzzing ----

DEMO := build/demo/cornell_hidden.png
demo: build/mlt
	@mkdir -p $(dir $(DEMO))
	build/mlt render scenes/cornell_hidden.txt --width 400 --height 400 --mutations 80 -o $(DEMO)
	@echo $(DEMO)

# Scenes too large to be stored.
scenes: build/scenes/made
build/scenes/made: scenes/generate_mesh.cpp | deps
	@mkdir -p build/scenes
	$(CXX) $(CONTRACT) $(WARNINGS) -O2 $< -o build/scenes/generate_mesh
	build/scenes/generate_mesh build/scenes
	@touch $@

# Embree is a measure for the rays' cost, used where libembree-dev is installed.
$(OUT)/bench/ray_bench: LIBS += $(if $(wildcard /usr/include/embree3/rtcore.h),-lembree3)
BENCHES := $(patsubst tests/bench/%.cpp,$(OUT)/bench/%,$(wildcard tests/bench/*.cpp))
$(OUT)/bench/%: $(OUT)/tests/bench/%.o $(call stage_objects,converge)
	@mkdir -p $(dir $@)
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) $^ $(LIBS) -o $@
# Rays with what instruction sets beyond the variant's own make of geometry; what does not trace is the variant's.
define RAY_BENCH
$(OUT)/$(1)/bench/ray_bench.o: tests/bench/ray_bench.cpp $$(FLAGS_FILE) | deps
	@mkdir -p $$(dir $$@)
	$$(SAY) "  compile $$@"
	$$(Q)$$(CXX) $$(CXXFLAGS) -Itests $$(SET_FLAGS_$(1)) $$(COPY_FLAGS_$(1)) -DMLT_BENCH_SET=$(1) -c $$< -o $$@
$(OUT)/bench/ray_bench_$(1): LIBS += $$(if $$(wildcard /usr/include/embree3/rtcore.h),-lembree3)
$(OUT)/bench/ray_bench_$(1): $(OUT)/$(1)/bench/ray_bench.o \
  $$(patsubst src/%.cpp,$(OUT)/$(1)/%.o,$$(wildcard src/geometry/*.cpp)) \
  $$(call objects,$$(foreach s,base math,$$(call sources,$$(s))) $$(addprefix src/render/,instruction_set.cpp \
    worker_pool.cpp) src/converge/statistics.cpp)
	@mkdir -p $$(dir $$@)
	$$(SAY) "  link    $$@"
	$$(Q)$$(CXX) $$(LDFLAGS) $$^ $$(LIBS) -o $$@
endef
$(foreach s,$(EXTRA_SETS),$(eval $(call RAY_BENCH,$(s))))
BENCHES += $(EXTRA_SETS:%=$(OUT)/bench/ray_bench_%)
# Builds without running.
benches: $(BENCHES)
# One table and build/bench/bench.csv; BENCH_QUICK=1 takes few runs.
bench: $(BENCHES) scenes
	tools/bench.sh build/bench $(FLAGS_FILE) $(BENCHES)

# Instruction counts of fixed jobs against a stored table.
bench-guard: $(OUT)/film_hash scenes | deps-extra
	tools/bench_guard.sh $(OUT)

# What a scene pays for features that it lacks, by instruction counts: film_hash as built with MLT_WITHOUT_FEATURE and
# MLT_ALWAYS_FEATURE (include/integrator/features.hpp), of which only the kernels and their choice differ.
ifneq ($(filter feature-cost,$(MAKECMDGOALS)),)
FEATURES := $(shell sed -n 's/^ *X.\([a-z_]*\), .*/\1/p' include/integrator/features.hpp)
endif
FEATURE_BUILDS := $(foreach f,$(FEATURES),without_$(f) always_$(f))
# $(call FEATURE_BUILD,folder,flag,sources that it concerns)
define FEATURE_BUILD
$(OUT)/$(1)/%.o: src/%.cpp $$(FLAGS_FILE)
	@mkdir -p $$(dir $$@)
	$$(SAY) "  compile $$@"
	$$(Q)$$(CXX) $$(CXXFLAGS) $(2) -c $$< -o $$@
$(OUT)/$(1)/film_hash: $$(patsubst src/%.cpp,$(OUT)/$(1)/%.o,$(3)) $$(call objects,tests/repro/film_hash.cpp) \
    $$(filter-out $$(KERNEL_SETS) $$(call objects,$(3)),$$(call stage_objects,render))
	$$(SAY) "  link    $$@"
	$$(Q)$$(CXX) $$(LDFLAGS) $$^ $$(filter-out $$(IMAGE_LIBS),$$(LIBS)) -o $$@
endef
$(foreach f,$(FEATURES),\
  $(eval $(call FEATURE_BUILD,without_$(f),-DMLT_WITHOUT_FEATURE=$(f),$(filter src/render/kernel_group_%.cpp,$(call sources,render))))\
  $(eval $(call FEATURE_BUILD,always_$(f),-DMLT_ALWAYS_FEATURE=$(f),src/render/scene_info.cpp)))
feature-cost: $(OUT)/film_hash $(FEATURE_BUILDS:%=$(OUT)/%/film_hash) | deps-extra
	tools/feature_cost.sh $(OUT) $(FEATURES)

# The estimated error against the true one on every scene.
calibration: build/mlt scenes
	tools/calibration.sh build/mlt

# The harnesses see the readers of input files alone.
FUZZERS := $(patsubst tests/fuzz/%_fuzz.cpp,$(OUT)/fuzz_%,$(wildcard tests/fuzz/*_fuzz.cpp))
READERS := $(call stage_objects,scene) \
           $(call objects,$(filter %/pfm_reader.cpp %/png_reader.cpp %/format.cpp,$(call sources,image)) \
             $(filter-out %/measure.cpp %/picture.cpp %/reference.cpp %/summary.cpp,$(call sources,converge)))
$(OUT)/fuzz_%: $(OUT)/tests/fuzz/%_fuzz.o $(READERS)
	$(SAY) "  link    $@"
	$(Q)$(CXX) $(LDFLAGS) -fsanitize=fuzzer $^ $(LIBS) -o $@
fuzzers: $(FUZZERS)
FUZZ_SECONDS ?= 600
fuzz: deps-extra
	tools/fuzz.sh $(FUZZ_SECONDS)

# ---- form ----

FORMATTED := $(wildcard include/*/*.hpp src/*/*.hpp src/*/*.cpp tests/*/*.hpp tests/*/*.cpp scenes/*.cpp)
format-check: deps-extra
	$(Q)clang-format --dry-run -Werror $(FORMATTED)

tidy: deps-extra
	clang-tidy --quiet $(wildcard src/*/*.cpp) -- $(CONTRACT) -Iinclude

clean:
	rm -rf build

.SECONDARY:
.DELETE_ON_ERROR:
-include $(wildcard $(OUT)/src/*/*.d $(EXTRA_SETS:%=$(OUT)/%/*/*.d) $(OUT)/tests/*/*.d $(OUT)/fault*/*.d \
           $(FEATURE_BUILDS:%=$(OUT)/%/render/*.d))
