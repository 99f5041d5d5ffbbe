//! The figures that the formulation prints.

/// Section, problem, cells per unit of length, and the figures: `name: value`, as printed.
pub(super) type Row = (&'static str, &'static str, usize, &'static str);

/// The figures as printed.
pub const PRINTED: [Row; 42] = [
    ("4", "half-open", 2, "iterations to 1e-10: 58"),
    (
        "4",
        "half-open",
        4,
        "η_NNDD, iteration 1: 0.671308; η_NNDD, iteration 2: 0.168909; η_NNDD, iteration 3: 0.0828234; \
         η_NNDD, iteration 4: 0.0560132; iterations to 1e-10: 65; smallest μ: 2; largest μ: 4.21",
    ),
    ("4", "half-open", 8, "iterations to 1e-10: 72"),
    (
        "6.1",
        "cube",
        3,
        "√a(u,u): 3.667533807; error: 0.5365340238; ‖τ−σ̂‖ by EET, body 1: 1.24376; ‖τ−σ̂‖ at best, body 1: 0.538909",
    ),
    (
        "6.1",
        "cube",
        6,
        "√a(u,u): 3.704162294; error: 0.2830070077; ‖τ−σ̂‖ by EET, body 1: 0.796868; e_CRE/error, step 0: 2.816; \
         e_CRE/error, step 1: 1.200; e_CRE/error, step 2: 1.092; e_CRE/error, step 3: 1.058; e_CRE/error, step 5: 1.035",
    ),
    (
        "6.1",
        "cube",
        12,
        "√a(u,u): 3.716781437; error: 0.1455544275; e_CRE/error, step 0: 3.18; e_CRE/error, step 1: 1.226; \
         e_CRE/error, step 2: 1.094; e_CRE/error, step 3: 1.053; e_CRE/error, step 5: 1.030",
    ),
    ("6.1", "weight", 2, "a(u,u), body 1: 0.420279269763; ‖τ−σ̂‖ by EET, body 1: 1.33932"),
    ("6.1", "weight", 4, "a(u,u), body 1: 0.465995189677; ‖τ−σ̂‖ by EET, body 1: 1.063121"),
    (
        "6.2",
        "circle",
        3,
        "nodes: 128; force, pair 1: 0.0213627178336; closed, pair 1: 4; nodes of pair 1: 16; error: 0.085964582; \
         relative error: 0.25; e_CRE by EET: 0.494544672; e_CRE at best: 0.0874639536; e_CRE/error, step 0: 5.75; \
         e_CRE/error, step 1: 1.570; e_CRE/error, step 2: 1.289; e_CRE/error, step 3: 1.198; \
         ‖τ−σ̂‖ by EET, body 1: 0.406193698; ‖τ−σ̂‖ by EET, body 2: 0.281501066; \
         ‖τ−σ̂‖ at best, body 1: 0.0667543917; ‖τ−σ̂‖ at best, body 2: 0.0534371807; 2∫po: 2.33077696e-4; \
         ‖û−u‖²: 1.0518439e-4",
    ),
    (
        "6.2",
        "circle",
        6,
        "nodes: 686; force, pair 1: 0.0195767322619; closed, pair 1: 15; nodes of pair 1: 49; error: 0.0463822047; \
         relative error: 0.14; e_CRE by EET: 0.289234537; e_CRE at best: 0.0467327023; e_CRE/error, step 0: 6.24; \
         e_CRE/error, step 1: 1.558; e_CRE/error, step 2: 1.251; e_CRE/error, step 3: 1.162; \
         e_CRE/error, step 5: 1.095; e_CRE/error, step 8: 1.067",
    ),
    (
        "6.2",
        "circle",
        12,
        "nodes: 4394; force, pair 1: 0.0190296047013; closed, pair 1: 50; nodes of pair 1: 169; error: 0.02400218104; \
         relative error: 0.073; e_CRE/error, step 0: 6.48; e_CRE/error, step 1: 1.541; e_CRE/error, step 2: 1.214; \
         e_CRE/error, step 3: 1.126",
    ),
    (
        "6.2",
        "circle",
        16,
        "nodes: 9826; force, pair 1: 0.0189795191778; closed, pair 1: 83; nodes of pair 1: 289; error: 0.01812908621; \
         relative error: 0.055; e_CRE/error, step 0: 6.53; e_CRE/error, step 1: 1.534; e_CRE/error, step 2: 1.201; \
         e_CRE/error, step 3: 1.114; a(u,u) of the exact field, body 1: 0.053678654",
    ),
    (
        "6.2",
        "circle, two materials",
        12,
        "e_CRE/error, step 0: 6.60; e_CRE/error, step 1: 1.476; e_CRE/error, step 2: 1.174; e_CRE/error, step 3: 1.109",
    ),
    (
        "6.3",
        "half-open",
        2,
        "nodes: 90; J: 0.19321909071; a(u,u), body 1: 0.224504065268; a(u,u), body 2: 0.121497965157; \
         force, pair 1: 13.3110052961; closed, pair 1: 12; nodes of pair 1: 15; e_CRE by EET: 2.20182561; \
         ‖τ−σ̂‖ at best, body 1: 0.4627115064; ‖τ−σ̂‖ at best, body 2: 0.1025906958",
    ),
    (
        "6.3",
        "half-open",
        4,
        "nodes: 450; J: 0.162120223154; force, pair 1: 11.7921623886; closed, pair 1: 30; nodes of pair 1: 45; \
         e_CRE by EET: 1.669669",
    ),
    (
        "6.3",
        "half-open",
        8,
        "nodes: 2754; J: 0.144298330688; force, pair 1: 11.0354946929; closed, pair 1: 90; nodes of pair 1: 153; \
         e_CRE by EET: 1.201888",
    ),
    (
        "11",
        "tilted on a sphere",
        2,
        "a(u,u), body 1: 0.3931869076; a(u,u), body 2: 0.02748541226; force, pair 1: 4.052897027; closed, pair 1: 5; \
         nodes of pair 1: 9; 2∫po with the lift: 2.311395831e-3; ‖û−u‖²: 9.978609e-3; ‖τ−σ̂‖ by EET, body 1: 2.692516658; \
         ‖τ−σ̂‖ by EET, body 2: 0.2919150214; ‖τ−σ̂‖ at best, body 1: 0.4618681635; ‖τ−σ̂‖ at best, body 2: 0.06165615515; \
         largest face p, pair 1: 9.312428584",
    ),
    (
        "11",
        "tilted on a sphere",
        4,
        "a(u,u), body 1: 0.2676602061; a(u,u), body 2: 0.01848638501; force, pair 1: 3.587972008; closed, pair 1: 14; \
         nodes of pair 1: 25; 2∫po with the lift: 5.417426145e-4; ‖û−u‖²: 7.771899e-4; ‖τ−σ̂‖ by EET, body 1: 1.760487865; \
         ‖τ−σ̂‖ by EET, body 2: 0.228142107; ‖τ−σ̂‖ at best, body 1: 0.275966535; ‖τ−σ̂‖ at best, body 2: 0.0422077593; \
         largest face p, pair 1: 11.61680526",
    ),
    (
        "11",
        "side moved on a sphere",
        2,
        "a(u,u), body 1: 0.3460013582; a(u,u), body 2: 0.2614639687; force, pair 1: 22.68663759; closed, pair 1: 9; \
         nodes of pair 1: 9; 2∫po with the lift: 9.537617753e-3; ‖û−u‖²: 0.03896569539; ‖τ−σ̂‖ by EET, body 1: 1.071332769; \
         ‖τ−σ̂‖ by EET, body 2: 0.8156418633; ‖τ−σ̂‖ at best, body 1: 0.3037163337; ‖τ−σ̂‖ at best, body 2: 0.179759864; \
         largest face p, pair 1: 32.99988623",
    ),
    (
        "11",
        "side moved on a sphere",
        4,
        "a(u,u), body 1: 0.3385001108; a(u,u), body 2: 0.1981241702; force, pair 1: 19.24987262; closed, pair 1: 25; \
         nodes of pair 1: 25; 2∫po with the lift: 2.287493187e-3; ‖û−u‖²: 0.0127343904; ‖τ−σ̂‖ by EET, body 1: 0.6559438783; \
         ‖τ−σ̂‖ by EET, body 2: 0.6682113433",
    ),
    (
        "11",
        "both sides moved on a sphere",
        2,
        "a(u,u), body 1: 0.4326967727; a(u,u), body 2: 0.0879354595; force, pair 1: 1.101151634; closed, pair 1: 3; \
         nodes of pair 1: 6; 2∫po with the lift: 1.592807438e-3; ‖û−u‖²: 1.089977128e-3; ‖τ−σ̂‖ by EET, body 1: 1.472794143; \
         ‖τ−σ̂‖ by EET, body 2: 0.611517744; ‖τ−σ̂‖ at best, body 1: 0.3150248454; ‖τ−σ̂‖ at best, body 2: 0.1186904876; \
         largest face p, pair 1: 2.803796287",
    ),
    (
        "11",
        "both sides moved on a sphere",
        4,
        "a(u,u), body 1: 0.4472446592; a(u,u), body 2: 0.08584099047; force, pair 1: 1.059477549; closed, pair 1: 10; \
         nodes of pair 1: 20; 2∫po with the lift: 2.782963812e-4; ‖û−u‖²: 4.336054e-4; ‖τ−σ̂‖ by EET, body 1: 0.9252851962; \
         ‖τ−σ̂‖ by EET, body 2: 0.456536596",
    ),
    (
        "11",
        "pressed on a sphere",
        2,
        "a(u,u), body 1: 0.2986857165; a(u,u), body 2: 0.2768181112; force, pair 1: 21.512459033; closed, pair 1: 9; \
         nodes of pair 1: 9; 2∫po with the lift: 0.01083159824; ‖û−u‖²: 4.9144800201e-3; ‖τ−σ̂‖ by EET, body 1: 0.45341985168; \
         ‖τ−σ̂‖ by EET, body 2: 0.51854979078; ‖τ−σ̂‖ at best, body 1: 0.21517552811; ‖τ−σ̂‖ at best, body 2: 0.1380329521; \
         largest P/ℓ, pair 1: 26.431686549; largest face p, pair 1: 22.411713013",
    ),
    (
        "11",
        "pressed on a sphere",
        4,
        "a(u,u), body 1: 0.3035432678; a(u,u), body 2: 0.3011568929; force, pair 1: 21.64876345; closed, pair 1: 25; \
         nodes of pair 1: 25; 2∫po with the lift: 3.4911770526e-3; ‖û−u‖²: 1.5874621588e-3; ‖τ−σ̂‖ by EET, body 1: 0.44302766387; \
         ‖τ−σ̂‖ by EET, body 2: 0.46769693456",
    ),
    (
        "11",
        "socket",
        2,
        "a(u,u), body 1: 0.391842168378; a(u,u), body 2: 0.993448365819; force, pair 1: 25.2883489031; closed, pair 1: 8; \
         nodes of pair 1: 9; largest mean P/ℓ, pair 1: 39.641618633; largest face p, pair 1: 72.940997746; 2∫po: 0.017324156014; \
         ‖û−u‖²: 0.038260399107; ‖τ−σ̂‖ by EET, body 1: 1.17961471732; ‖τ−σ̂‖ by EET, body 2: 3.30426012294; \
         ‖τ−σ̂‖ at best, body 1: 0.31989003239; ‖τ−σ̂‖ at best, body 2: 0.79623306435; e_CRE by EET: 3.5164201109; \
         e_CRE at best: 0.88988835294",
    ),
    (
        "11",
        "socket",
        4,
        "a(u,u), body 1: 0.418711046427; a(u,u), body 2: 1.28900312416; force, pair 1: 25.1028124575; closed, pair 1: 19; \
         nodes of pair 1: 25; largest mean P/ℓ, pair 1: 59.742733811; largest face p, pair 1: 74.943701983; 2∫po: 0.0068515864248; \
         ‖û−u‖²: 0.014789808086; ‖τ−σ̂‖ by EET, body 1: 0.7703146733; ‖τ−σ̂‖ by EET, body 2: 2.54600804589; \
         e_CRE by EET: 2.6640538771",
    ),
    (
        "12",
        "stack",
        2,
        "a(u,u), body 1: 0.074421493018; a(u,u), body 2: 0.19360354267; a(u,u), body 3: 0.7842195355; \
         force, pair 1: 9.6342837836; force, pair 2: 29.634283784; closed, pair 1: 9; closed, pair 2: 12; \
         nodes of pair 1: 15; largest P/ℓ, pair 1: 12.456643655; largest P/ℓ, pair 2: 37.545624264; \
         largest p, pair 1: 21.133936192; largest p, pair 2: 47.051503455; 2∫po: 0.014910899495; \
         ‖û−u‖²: 0.020005305292; ‖τ−σ̂‖ by EET, body 1: 0.70201261287; ‖τ−σ̂‖ by EET, body 2: 0.90894651981; \
         ‖τ−σ̂‖ by EET, body 3: 1.7444239945; ‖τ−σ̂‖ at best, body 1: 0.16664695537; \
         ‖τ−σ̂‖ at best, body 2: 0.30049628353; ‖τ−σ̂‖ at best, body 3: 0.5733010972; e_CRE by EET: 2.0968873985; \
         e_CRE at best: 0.6940169861; e_CRE of 4 steps/distance to 4 n: 1.370",
    ),
    (
        "12",
        "stack",
        4,
        "a(u,u), body 1: 0.092085768779; a(u,u), body 2: 0.23550347513; a(u,u), body 3: 0.9256704223; \
         force, pair 1: 9.9263649279; force, pair 2: 29.926364928; closed, pair 1: 25; closed, pair 2: 31; \
         nodes of pair 1: 45; largest P/ℓ, pair 1: 15.224831478; largest P/ℓ, pair 2: 50.54492707; \
         largest p, pair 1: 18.273890502; largest p, pair 2: 53.965075805; 2∫po: 3.6645904409e-3; \
         ‖û−u‖²: 8.0179018567e-3; ‖τ−σ̂‖ by EET, body 1: 0.58606022086; ‖τ−σ̂‖ by EET, body 2: 0.78110617748; \
         ‖τ−σ̂‖ by EET, body 3: 1.5040683795; e_CRE by EET: 1.7965237614",
    ),
    (
        "12",
        "corner",
        2,
        "a(u,u), body 1: 0.35374292042; force, pair 1: 7; force, pair 2: 7; force, pair 3: 20; closed, pair 1: 7; \
         closed, pair 2: 8; closed, pair 3: 9; nodes of pair 1: 9; largest P/ℓ, pair 1: 10.955738063; \
         largest P/ℓ, pair 2: 11.084672156; largest P/ℓ, pair 3: 27.469860368; largest p, pair 1: 14.888799012; \
         largest p, pair 2: 14.889858671; largest p, pair 3: 33.571729631; 2∫po: 1.2006631233e-3; \
         ‖û−u‖²: 2.0002898109e-3; ‖τ−σ̂‖ by EET, body 1: 0.97388058756; ‖τ−σ̂‖ at best, body 1: 0.24031901764; \
         e_CRE by EET: 0.97552260443; e_CRE at best: 0.24688900983; e_CRE of 4 steps/distance to 6 n: 1.148",
    ),
    (
        "12",
        "corner",
        4,
        "a(u,u), body 1: 0.38321664665; force, pair 1: 7; force, pair 2: 7; force, pair 3: 20; closed, pair 1: 20; \
         closed, pair 2: 21; closed, pair 3: 25; nodes of pair 1: 25; largest P/ℓ, pair 1: 11.954897176; \
         largest P/ℓ, pair 2: 12.619325225; largest P/ℓ, pair 3: 30.680049828; largest p, pair 1: 13.224028866; \
         largest p, pair 2: 13.693593086; largest p, pair 3: 32.369741381; 2∫po: 5.2131883791e-4; \
         ‖û−u‖²: 3.1879303474e-4; ‖τ−σ̂‖ by EET, body 1: 0.82427449024; e_CRE by EET: 0.82478393967",
    ),
    (
        "12",
        "sphere",
        2,
        "a(u,u), body 1: 1.7177225681; force, pair 1: 20.16981422; closed, pair 1: 3; nodes of pair 1: 9; \
         largest P/ℓ, pair 1: 173.78789524",
    ),
    (
        "12",
        "sphere",
        4,
        "a(u,u), body 1: 1.5911981932; force, pair 1: 20.185458679; closed, pair 1: 4; nodes of pair 1: 25; \
         largest P/ℓ, pair 1: 158.79410443",
    ),
    (
        "12",
        "middle of the stack pushed",
        2,
        "unresisted load: 6; its motion along x: 0; along y: 1; along z: 0",
    ),
    (
        "12",
        "middle of the stack pushed",
        4,
        "unresisted load: 6; its motion along x: 0; along y: 1; along z: 0",
    ),
    ("12", "corner pulled", 2, "its motion along x: 1; along y: 0; along z: 0"),
    (
        "13",
        "friction, s = 1",
        2,
        "a(u,u), body 1: 0.564472686; a(u,u), body 2: 0.3082336346; force, pair 1: 24.764834284; \
         friction x, pair 1: 1.9545872; friction y, pair 1: 0.32202307846; sticking, pair 1: 0; slipping, pair 1: 12; \
         closed, pair 1: 12; nodes of pair 1: 15; 2∫po: 8.1559461208e-3; friction term: 1.57101165e-4; \
         friction term, 16 parts a face: 8.3808864e-5; ‖û−u‖², body 1: 1.295267877e-3; ‖û−u‖², body 2: 2.0195669692e-3; \
         ‖τ−σ̂‖ by EET, body 1: 1.4969519147; ‖τ−σ̂‖ by EET, body 2: 0.75802132353; \
         e_CRE by EET, 16 parts a face: 1.6813732339; e_CRE at best, 16 parts a face: 0.55520948398; \
         e_CRE of 4 steps/distance to 4 n: 1.404",
    ),
    (
        "13",
        "friction, s = 4",
        2,
        "a(u,u), body 1: 0.54675983418; a(u,u), body 2: 0.33204164384; force, pair 1: 24.989325589; \
         friction x, pair 1: 4.7873623725; friction y, pair 1: 0.76397496821; sticking, pair 1: 10; slipping, pair 1: 2; \
         closed, pair 1: 12; nodes of pair 1: 15; 2∫po: 9.5689963446e-3; friction term: 4.8991609658e-5; \
         friction term, 16 parts a face: 4.4930220674e-5; ‖û−u‖², body 1: 1.5066376717e-3; ‖û−u‖², body 2: 2.2099435582e-3; \
         ‖τ−σ̂‖ by EET, body 1: 1.4234744992; ‖τ−σ̂‖ by EET, body 2: 0.77129898734; \
         e_CRE by EET, 16 parts a face: 1.6231180751; e_CRE at best, 16 parts a face: 0.52696609916; \
         e_CRE of 4 steps/distance to 4 n: 1.428",
    ),
    (
        "13",
        "friction, s = 8",
        2,
        "a(u,u), body 1: 0.54290944048; a(u,u), body 2: 0.33359928595; force, pair 1: 24.93489024; \
         friction x, pair 1: 4.8210005654; friction y, pair 1: 0.76659451381; sticking, pair 1: 12; slipping, pair 1: 0; \
         closed, pair 1: 12; nodes of pair 1: 15; 2∫po: 9.1160747328e-3; ‖û−u‖², body 1: 1.6741838311e-3; \
         ‖û−u‖², body 2: 2.2902129385e-3; ‖τ−σ̂‖ by EET, body 1: 1.4167678661; ‖τ−σ̂‖ by EET, body 2: 0.77822199757; \
         e_CRE by EET, 16 parts a face: 1.6204755892; e_CRE at best, 16 parts a face: 0.52010391877",
    ),
    (
        "13",
        "friction, s = 1",
        4,
        "a(u,u), body 1: 0.65475295352; a(u,u), body 2: 0.30292659509; force, pair 1: 23.939858753; \
         friction x, pair 1: 1.9659450185; friction y, pair 1: 0.2525442343; sticking, pair 1: 0; slipping, pair 1: 39; \
         closed, pair 1: 39; nodes of pair 1: 45; 2∫po: 4.9498224672e-4; friction term: 6.6918846332e-5; \
         friction term, 16 parts a face: 3.5666613907e-5; ‖û−u‖², body 1: 2.3362116646e-4; ‖û−u‖², body 2: 4.6927999498e-4; \
         ‖τ−σ̂‖ by EET, body 1: 1.316532336; ‖τ−σ̂‖ by EET, body 2: 0.54572915092; \
         e_CRE by EET, 16 parts a face: 1.4255915431",
    ),
    (
        "13",
        "friction, s = 4",
        4,
        "a(u,u), body 1: 0.61454044529; a(u,u), body 2: 0.33220410009; force, pair 1: 24.076920633; \
         friction x, pair 1: 4.9564951389; friction y, pair 1: 0.54140861371; sticking, pair 1: 23; slipping, pair 1: 13; \
         closed, pair 1: 36; nodes of pair 1: 45; 2∫po: 4.3522407925e-4; friction term: 7.4235226346e-5; \
         friction term, 16 parts a face: 5.404909838e-5; ‖û−u‖², body 1: 3.0208369199e-4; ‖û−u‖², body 2: 5.5552142471e-4; \
         ‖τ−σ̂‖ by EET, body 1: 1.2094877476; ‖τ−σ̂‖ by EET, body 2: 0.53633642809; \
         e_CRE by EET, 16 parts a face: 1.3235800897",
    ),
    (
        "13",
        "friction, s = 8",
        4,
        "a(u,u), body 1: 0.60371740636; a(u,u), body 2: 0.34080484398; force, pair 1: 24.045050709; \
         friction x, pair 1: 5.1371692888; friction y, pair 1: 0.55309881644; sticking, pair 1: 36; slipping, pair 1: 0; \
         closed, pair 1: 36; nodes of pair 1: 45; 2∫po: 5.2317924645e-4; friction term: 9.6737585e-5; \
         friction term, 16 parts a face: 9.6020573e-5; ‖û−u‖², body 1: 3.3500444e-4; ‖û−u‖², body 2: 5.6774465e-4; \
         ‖τ−σ̂‖ by EET, body 1: 1.1690844742; ‖τ−σ̂‖ by EET, body 2: 0.55388908482; \
         e_CRE by EET, 16 parts a face: 1.2942463348",
    ),
    (
        "13",
        "stack with friction",
        4,
        "a(u,u), body 1: 0.11547001942; a(u,u), body 2: 0.2521661677; a(u,u), body 3: 0.76729389979; \
         force, pair 1: 9.7283630696; force, pair 2: 29.72836307; friction x, pair 1: 2.6887858309; \
         friction y, pair 1: 5.6968649555; friction x, pair 2: 2.6887858309; friction y, pair 2: -0.30313504446; \
         sticking, pairs: 35; slipping, pairs: 28; 2∫po: 2.8970759805e-3; friction term: 6.3205841782e-4; \
         friction term, 16 parts a face: 5.1789225652e-4; ‖û−u‖², body 1: 2.9923540523e-3; ‖û−u‖², body 2: 2.6055845605e-3; \
         ‖û−u‖², body 3: 2.0236820794e-3; ‖τ−σ̂‖ by EET, body 1: 0.61707171954; ‖τ−σ̂‖ by EET, body 2: 0.60355997993; \
         ‖τ−σ̂‖ by EET, body 3: 1.2697394266; e_CRE by EET, 16 parts a face: 1.5389402057",
    ),
];
