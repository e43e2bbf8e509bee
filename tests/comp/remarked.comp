/* Comments before anything, with "quotes and ; in them
   over lines. */
component /* here */ remarked // and here
    "Comments everywhere; blanks as one likes." ;
pin  in   float
    in // the input
    ;
pin out float out;pin out float twice ;   // two on a line
// pin in float gone;
/* param rw float gone; */
param rw float gain=2/* no blanks */"It's a gain; really // so";
function _;license"MIT";
variable int*p;variable double d=1;
option   extra_compile_args   "-DREMARKED=1" ;
;;
/* ;; in the C text means nothing:
;;
*/
out = in * gain; // "
twice = REMARKED + d + (p == 0);
